"""The laboratory: which technique lowers the noise, by how much, at what cost.

`study` says what is compared, `run` measures it (`replicates`) and judges it (`statistics`),
`results` holds what was found, and `alight.study` does all of it.

Examples
--------
>>> from alight.lab.study import ArmSpec, SceneSpec, Study
>>> arms = [ArmSpec("mis"), ArmSpec("bsdf", {"light_sampling": "bsdf"})]
>>> study = Study("mine", arms=arms, scenes=[SceneSpec("cornell-box")])
>>> print(alight.study(study))  # doctest: +SKIP
"""

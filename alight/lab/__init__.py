"""The laboratory: which technique lowers the noise, by how much, at what cost.

`study` says what is compared, `run` measures it, `results` holds what was found.

Examples
--------
>>> from alight.lab.run import run_study
>>> from alight.lab.study import ArmSpec, SceneSpec, Study
>>> arms = [ArmSpec("mis"), ArmSpec("bsdf", {"light_sampling": "bsdf"})]
>>> study = Study("mine", arms=arms, scenes=[SceneSpec("cornell-box")])
>>> run_study(study, "study-mine")  # doctest: +SKIP
"""

"""A study of two arms: what light sampling with MIS gains over BSDF sampling alone.

Writes arms/report.html and the numbers beside it. Run again to go on after an interruption.
"""

from pathlib import Path

import alight

STUDY = """
title: Two ways to find a lamp
scenes:
  - {scene: cornell-box, set: {size: [24, 24]}, reference: {spp: 4096}}
arms:
  bsdf: {label: BSDF sampling alone, light_sampling: bsdf}
  mis: {label: light and BSDF sampling}
baseline: bsdf
spp: [4, 16]
equal_time: false
replicates: 8
"""

if __name__ == "__main__":
    Path("two-arms.yaml").write_text(STUDY, encoding="utf-8")
    print(alight.study("two-arms.yaml", output="arms"))

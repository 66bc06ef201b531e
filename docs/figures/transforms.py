"""Figure of docs/theory/transforms.md: a mobile, six levels of nodes with one transform each."""

from pictures import render, save_beside

LEVELS = 6
COLORS = ([0.75, 0.2, 0.15], [0.85, 0.6, 0.1], [0.2, 0.5, 0.3], [0.15, 0.35, 0.65])


def arm(level: int, side: int) -> str:
    """A bar with a smaller arm at each end, or a ball where it ends."""
    color = COLORS[level % len(COLORS)]
    bar = f"{{shape: cube, transform: {{scale: [1, 0.03, 0.03]}}, bsdf: {paint(color)}}}"
    if level == LEVELS:
        return f"{{shape: sphere, transform: {{scale: 0.45}}, bsdf: {paint(color)}}}"
    children = [f"bar: {bar}"]
    for name, x in (("left", -1), ("right", 1)):
        # Scale first, then turn about the thread, then hang below the end of the bar: T R S.
        steps = (
            f"[{{scale: 0.58}}, {{rotate: {{axis: y, angle: {35 + 20 * x + 15 * side}}}}}, "
            f"{{translate: [{x}, -0.62, 0]}}]"
        )
        thread = (
            f"{{shape: cube, bsdf: {paint([0.3, 0.3, 0.3])}, transform: "
            f"[{{scale: [0.008, 0.31, 0.008]}}, {{translate: [{x}, -0.31, 0]}}]}}"
        )
        lower = f"{{transform: {steps}, children: {{arm: {arm(level + 1, x)}}}}}"
        children += [f"{name}-thread: {thread}", f"{name}: {lower}"]
    return "{children: {" + ", ".join(children) + "}}"


def paint(color: list[float]) -> str:
    """A matte colour."""
    return f"{{type: diffuse, reflectance: {color}}}"


def scene() -> str:
    """The scene as text."""
    return f"""
camera:
  fov: 30
  transform: {{look_at: {{origin: [0, -0.6, 5.2], target: [-0.3, -0.85, 0]}}}}
film: {{size: [800, 500]}}
environment: {{type: constant, radiance: 0.9}}
nodes:
  mobile:
    transform: {{rotate: {{axis: y, angle: 20}}}}
    children: {{arm: {arm(1, 0)}}}
  wall:
    shape: plane
    transform: {{translate: [0, 0, -2.5]}}
    bsdf: {{type: diffuse, reflectance: 0.7}}
"""


if __name__ == "__main__":
    save_beside("theory-transforms", render(scene()))

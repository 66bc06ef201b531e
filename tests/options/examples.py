"""A value for every option, as Python gives it, other than its default."""

from alight.options.kinds import (
    Choice,
    Crop,
    Definitions,
    File,
    Files,
    Names,
    Size,
    Switch,
    Text,
    Texts,
    listed,
)
from alight.options.quantities import Frames, Number, Part, Seconds, Share, Whole


def example(option):
    """A value that the option takes."""
    kind = option.kind
    by_kind = {
        Seconds: lambda: 12.25,
        Share: lambda: 0.6789,
        Number: lambda: 0.375,
        Size: lambda: (24, 16),
        Crop: lambda: (4, 2, 8, 8),
        Part: lambda: (3, 40),
        Frames: lambda: (3, 40),
        Switch: lambda: not option.default,
        File: lambda: "some/file.png",
        Files: lambda: ["a b.png", "c.png"],
        Texts: lambda: ["film.size=[8, 8]", "a=b=c"],
        Definitions: lambda: {"spp": "64", "scene": "a=b"},
        Text: lambda: "name",
        Whole: lambda: kind.least + 1,
        Choice: lambda: listed(kind.known)[-1],
        Names: lambda: listed(kind.known)[:2],
    }
    return by_kind[type(kind)]()


#: Values that no option of a kind takes, as Python and as a command line gives them.
WRONG = {
    Seconds: [(-1.0, None), ("soon", "soon"), (True, None), (float("nan"), None)],
    Share: [(-0.1, None), ("half", "half"), (11.0, "1100%"), (True, None)],
    Number: [(1e12, "1e12"), ("many", "many"), (True, None), (float("nan"), "nan")],
    Size: [("big", "big"), ((1, 2, 3), None), (1.5, None)],
    Crop: [("1,2,3", "1,2,3"), ((1, 2, 3), None)],
    Part: [("0/3", "0/3"), ((4, 3), None), ((True, 3), None), (2, None)],
    Frames: [("3", "3"), ((4, 4), None), ("4:3", "4:3"), (2, None)],
    Switch: [(1, None), ("yes", None)],
    File: [(3, None)],
    Files: [(3, None), ([3], None)],
    Texts: [([3], None)],
    Definitions: [(["a"], None)],
    Text: [],
    Whole: [(-1, "-1"), (2**40, str(2**40)), ("many", "many"), (2.5, "2.5"), (True, None)],
    Choice: [("neither", "neither")],
    Names: [(["wrong"], "wrong"), (3, None), ([3], None)],
}

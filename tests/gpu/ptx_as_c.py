"""PTX run by the processor: each instruction as a line of C, for what our kernels consist of.

What is written here follows the text of NVIDIA's PTX ISA reference manual. Approximate division and
roots are exact ones, local memory is an array of the function.
"""

import ctypes
import re
import subprocess
from collections.abc import Sequence
from pathlib import Path

_TYPES = {
    "b32": "uint32_t", "u32": "uint32_t", "s32": "int32_t", "f32": "float",
    "b64": "uint64_t", "u64": "uint64_t", "s64": "int64_t", "f64": "double",
    "b8": "uint8_t", "u8": "uint8_t", "s8": "int8_t",
    "b16": "uint16_t", "u16": "uint16_t", "s16": "int16_t", "pred": "int",
}  # fmt: skip

_HEAD = """#include <stdint.h>
#include <string.h>
#include <math.h>
static float f_(uint32_t x) { float y; memcpy(&y, &x, 4); return y; }
static uint32_t b_(float x) { uint32_t y; memcpy(&y, &x, 4); return y; }
static double d_(uint64_t x) { double y; memcpy(&y, &x, 8); return y; }
static uint64_t l_(double x) { uint64_t y; memcpy(&y, &x, 8); return y; }
static uint32_t brev_(uint32_t x) {
  uint32_t y = 0; for (int i = 0; i < 32; i++) y |= (x >> i & 1) << (31 - i); return y; }
static int64_t clamp_(double x, double lo, double hi) {
  int64_t top = hi > 9e18 ? INT64_MAX : (int64_t)hi;
  return x != x ? 0 : x <= lo ? (int64_t)lo : x >= hi ? top : (int64_t)x; }
static float min_(float a, float b) { return a != a ? b : b != b ? a : a < b ? a : b; }
static float max_(float a, float b) { return a != a ? b : b != b ? a : a > b ? a : b; }
#define sat_shl_(x, n, w) ((n) >= w ? 0 : (x) << (n))
#define sat_shr_(x, n, w) ((n) >= w ? ((x) < 0 ? -1 : 0) : (x) >> (n))
static const int tid_ = 0;
"""

_INFIX = {
    "add": "+",
    "sub": "-",
    "mul": "*",
    "and": "&",
    "or": "|",
    "xor": "^",
    "div": "/",
    "rem": "%",
}
_COMPARE = {"lt": "<", "le": "<=", "gt": ">", "ge": ">=", "eq": "==", "ne": "!=",
            "lo": "<", "ls": "<=", "hi": ">", "hs": ">="}  # fmt: skip


def c_of(ptx: str) -> str:
    """C of the one entry of a module: ``void run(const uint64_t *params, uint32_t block)``."""
    start = ptx.index(".visible .entry")
    signature, body = ptx[start:].split("{", 1)
    names = re.findall(r"\.param \.\w+ (?:\.ptr .*?)?(\w+_param_\d+)", signature)
    place = {name: i for i, name in enumerate(names)}
    lines = [_HEAD]
    lines += _tables(ptx[:start])
    lines += ["void run(const uint64_t *params, uint32_t block, uint32_t thread) {"]
    for line in body.split("\n"):
        text = re.sub(r"//.*", "", line).strip()
        if text and text != "}":
            lines.append(_line(text, place))
    return "\n".join([*lines, "}"])


def _tables(text: str) -> list[str]:
    found = []
    pattern = r"\.global \.align \d+ \.(b8|b32|b64|u64) (\w+)\[(\d+)\](?: = \{([^}]*)\})?;"
    for kind, name, count, values in re.findall(pattern, text):
        given = values or "0"
        found.append(
            f"static {_TYPES[kind]} {name}[{count}] __attribute__((aligned(64))) = {{{given}}};"
        )
    return found


def _line(text: str, place: dict[str, int]) -> str:
    if text.endswith(":"):
        return text.replace("$", "_") + ";"
    text = text.rstrip(";")
    if text.startswith(".pragma"):
        return ""
    if text.startswith(".reg"):
        kind, name, count = re.match(r"\.reg \.(\w+)\s+%(\w+)(<\d+>)?", text).groups()
        return f"{_TYPES[kind]} {name}{f'[{count[1:-1]}]' if count else ''};"
    if text.startswith(".local"):
        align, name, size = re.match(r"\.local \.align (\d+) \.b8\s+(\w+)\[(\d+)\]", text).groups()
        return f"uint8_t {name}[{size}] __attribute__((aligned({align})));"
    guard = ""
    if text.startswith("@"):
        condition, text = text.split(None, 1)
        sign = "!" if condition[1] == "!" else ""
        guard = f"if ({sign}({_register(condition.lstrip('@!'))})) "
    opcode, _, rest = text.partition(" ")
    opcode = opcode.strip()
    operands = [
        part.strip()
        for part in re.findall(r"\{[^}]*\}|\[[^\]]*\]|[^,]+", rest.strip())
        if part.strip()
    ]
    return guard + "{" + _statement(opcode.split("."), operands, place) + "}"


def _register(name: str) -> str:
    name = name.strip()
    if found := re.fullmatch(r"%([a-z]+)(\d+)", name):
        return f"{found[1]}[{found[2]}]"
    return {"%ctaid.x": "block", "%tid.x": "thread", "%SP": "SP", "%SPL": "SPL"}[name]


def _value(word: str, kind: str) -> str:
    """An operand as a value of a type."""
    if word.startswith("0f"):
        return f"f_(0x{word[2:]}u)" if kind == "f32" else f"0x{word[2:]}u"
    if word.startswith("0d"):
        return f"d_(0x{word[2:]}ull)"
    if re.fullmatch(r"-?(0x)?[0-9a-fA-F]+U?", word):
        if kind == "f32":
            return f"f_({word})"
        return f"(({_TYPES[kind]}){word.rstrip('U')}ll)"
    if word.startswith("%"):
        register = _register(word)
        if kind == "f32":
            return f"f_({register})"
        if kind == "f64":
            return f"d_({register})"
        return register if kind == "pred" else f"(({_TYPES[kind]}){register})"
    return f"((uint64_t){word})"


def _store(target: str, kind: str, value: str) -> str:
    register = _register(target)
    if kind == "f32":
        value = f"b_({value})"
    elif kind == "f64":
        value = f"l_({value})"
    elif kind == "pred":
        value = f"({value}) != 0"
    else:
        value = f"({_TYPES[kind]})({value})"
    return f"{register} = {value};"


def _address(word: str) -> str:
    inside = word.strip("[]")
    base, _, offset = inside.partition("+")
    start = _register(base) if base.startswith("%") else f"(uint64_t){base}"
    return f"({start} + ({offset or 0}))"


def _statement(op: list[str], args: list[str], place: dict[str, int]) -> str:
    name, kind = op[0], op[-1]
    width = int(re.sub(r"\D", "", kind) or 32)
    if name == "bra":
        return f"goto {args[0].replace('$', '_')};"
    if name == "ret":
        return "return;"
    if name in ("ld", "st"):
        return _access(name, op, args, place)
    if name in ("mov", "cvta"):
        if name == "cvta":
            return _store(args[0], "u64", _value(args[1], "u64"))
        if args[0].startswith("{"):
            low, high = args[0].strip("{}").split(",")
            half = {"b64": "b32", "b32": "b16"}[kind]
            value = _value(args[1], kind)
            return "".join(
                _store(part.strip(), half, f"{value} >> {shift}")
                for part, shift in ((low, 0), (high, width // 2))
                if part.strip() != "_"
            )
        if args[1].startswith("{"):
            half = {"b64": "b32", "b32": "b16"}[kind]
            low, high = (_value(part.strip(), half) for part in args[1].strip("{}").split(","))
            t = _TYPES[kind]
            return _store(args[0], kind, f"({t}){low} | ({t}){high} << {width // 2}")
        return _store(args[0], kind, _value(args[1], kind))
    if name == "setp":
        return _setp(op, args)
    if name == "selp":
        a, b = _value(args[1], kind), _value(args[2], kind)
        return _store(args[0], kind, f"{_register(args[3])} ? {a} : {b}")
    if name == "cvt":
        return _cvt(op, args)
    values = [_value(word, kind) for word in args[1:]]
    return _store(args[0], *_arithmetic(name, op, kind, width, values, args))


def _arithmetic(
    name: str, op: list[str], kind: str, width: int, v: list[str], args: list[str]
) -> tuple[str, str]:
    """Type and value of what an instruction of numbers gives."""
    if name == "mul" and op[1] == "wide":
        big = {"u32": "u64", "s32": "s64", "u16": "u32", "s16": "s32"}[kind]
        return big, f"({_TYPES[big]}){v[0]} * ({_TYPES[big]}){v[1]}"
    if name == "mul" and op[1] == "hi":
        if width == 32:
            return kind, f"(({'u' if kind[0] == 'u' else ''}int64_t){v[0]} * {v[1]}) >> 32"
        t = "unsigned __int128" if kind[0] == "u" else "__int128"
        return kind, f"(({t}){v[0]} * ({t}){v[1]}) >> 64"
    if name == "mad" and op[1] == "wide":
        big = {"u32": "u64", "s32": "s64"}[kind]
        return big, f"({_TYPES[big]}){v[0]} * ({_TYPES[big]}){v[1]} + {_value(args[3], big)}"
    if name == "mad":
        return kind, f"{v[0]} * {v[1]} + {v[2]}"
    if name == "fma":
        return kind, f"__builtin_fma{'f' if kind == 'f32' else ''}({v[0]}, {v[1]}, {v[2]})"
    if kind == "pred" and name == "not":
        return kind, f"!{v[0]}"
    if name in _INFIX:
        return kind, f"{v[0]} {_INFIX[name]} {v[1]}"
    if name == "not":
        return kind, f"~{v[0]}"
    if name == "neg":
        return kind, f"-{v[0]}"
    if name == "shl":
        return kind, f"sat_shl_({v[0]}, {_value(args[2], 'u32')}, {width})"
    if name == "shr":
        return kind, f"sat_shr_({v[0]}, {_value(args[2], 'u32')}, {width})"
    if name == "shf":
        pair = f"((uint64_t){v[1]} << 32 | {v[0]})"
        shift = f"({v[2]} & 31)"
        return kind, f"({pair} << {shift}) >> 32" if op[1] == "l" else f"{pair} >> {shift}"
    if name == "bfe":
        a, b = _value(args[2], "u32"), _value(args[3], "u32")
        return kind, f"({v[0]} >> {a}) & ((({_TYPES[kind]})1 << {b}) - 1)"
    if name in ("min", "max"):
        if kind == "f32":
            return kind, f"{name}_({v[0]}, {v[1]})"
        sign = "<" if name == "min" else ">"
        return kind, f"{v[0]} {sign} {v[1]} ? {v[0]} : {v[1]}"
    if name == "abs":
        return kind, f"fabsf({v[0]})" if kind == "f32" else f"({v[0]} < 0 ? -{v[0]} : {v[0]})"
    if name == "copysign":
        # The first operand gives the sign.
        return kind, f"copysignf({v[1]}, {v[0]})"
    one = {"sqrt": "sqrtf({0})", "rcp": "1.0f / {0}", "rsqrt": "1.0f / sqrtf({0})",
           "brev": "brev_({0})", "popc": "__builtin_popcountll({0})"}  # fmt: skip
    if name in one:
        return ("u32" if name == "popc" else kind), one[name].format(v[0])
    if name == "clz":
        return "u32", f"{v[0]} ? __builtin_clz{'ll' if width == 64 else ''}({v[0]}) : {width}"
    raise NotImplementedError(" ".join([*op, *args]))


def _setp(op: list[str], args: list[str]) -> str:
    compare, kind = op[1], op[-1]
    a, b = _value(args[1], kind), _value(args[2], kind)
    if compare in ("nan", "num"):
        either = f"({a} != {a} || {b} != {b})"
        return _store(args[0], "pred", either if compare == "nan" else f"!{either}")
    if kind in ("f32", "f64") and compare.endswith("u") and compare != "u":
        base = _COMPARE[compare[:-1]]
        return _store(args[0], "pred", f"({a} != {a}) || ({b} != {b}) || {a} {base} {b}")
    if kind in ("f32", "f64") and compare == "ne":
        return _store(args[0], "pred", f"{a} == {a} && {b} == {b} && {a} != {b}")
    return _store(args[0], "pred", f"{a} {_COMPARE[compare]} {b}")


def _cvt(op: list[str], args: list[str]) -> str:
    target, source = op[-2], op[-1]
    value = _value(args[1], source)
    rounding = op[1] if len(op) > 3 else ""
    if source == "f32" and target == "f32":
        function = {"rmi": "floorf", "rni": "rintf", "rzi": "truncf", "rpi": "ceilf"}[rounding]
        return _store(args[0], target, f"{function}({value})")
    if source in ("f32", "f64") and target not in ("f32", "f64"):
        low, high = {"s32": ("-2147483648.0", "2147483647.0"), "u32": ("0.0", "4294967295.0"),
                     "s64": ("-9223372036854775808.0", "9223372036854775807.0"),
                     "u64": ("0.0", "18446744073709551615.0")}[target]  # fmt: skip
        function = {"rmi": "floor", "rni": "rint", "rzi": "trunc", "rpi": "ceil"}[rounding]
        return _store(args[0], target, f"clamp_({function}((double){value}), {low}, {high})")
    return _store(args[0], target, f"({_TYPES[target]}){value}")


def _access(name: str, op: list[str], args: list[str], place: dict[str, int]) -> str:
    kind = op[-1]
    memory, word = (args[1], args[0]) if name == "ld" else (args[0], args[1])
    parameter = memory.strip("[]")
    if parameter in place:
        return _store(word, kind, f"*({_TYPES[kind]}*)(params + {place[parameter]})")
    parts = [part.strip() for part in word.strip("{}").split(",")]
    size = int(re.sub(r"\D", "", kind)) // 8
    found = []
    for i, part in enumerate(parts):
        where = f"*({_TYPES[kind]}*)({_address(memory)} + {i * size})"
        if name == "st":
            value = _value(part, kind)
            found.append(f"{where} = {value};")
        elif part != "_":
            raw = f"b_({where})" if kind == "f32" else f"l_({where})" if kind == "f64" else where
            found.append(f"{_register(part)} = {raw};")
    return "".join(found)


class PtxOnTheProcessor:
    """The entry of some PTX, to be run thread by thread."""

    def __init__(self, ptx: str, folder: Path) -> None:
        source, library = folder / "ptx.c", folder / "ptx.so"
        source.write_text(c_of(ptx))
        command = ["gcc", "-O0", "-w", "-fno-strict-aliasing", "-ffp-contract=off", "-mfma",
                   "-shared", "-fPIC", str(source), "-o", str(library), "-lm"]  # fmt: skip
        subprocess.run(command, check=True)
        self._run = ctypes.CDLL(str(library)).run
        self._run.argtypes = [ctypes.c_void_p, ctypes.c_uint32, ctypes.c_uint32]

    def launch(self, arguments: Sequence, kinds: Sequence[str], block: int) -> None:
        """Run as many threads as the last argument says."""
        words = (ctypes.c_uint64 * len(arguments))()
        for i, (kind, value) in enumerate(zip(kinds, arguments, strict=True)):
            if kind == "float":
                ctypes.cast(ctypes.byref(words, 8 * i), ctypes.POINTER(ctypes.c_float))[0] = value
            else:
                words[i] = int(value) & (2**64 - 1)
        for number in range(arguments[-1]):
            self._run(ctypes.byref(words), number // block, number % block)

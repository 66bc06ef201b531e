"""Bugs of the SPMD compiler."""

from tests.mutants.mutant import Mutant

ADAPTER = "tests/lanewise/test_adapter.py::test_all_assumptions_hold"
KEPT = "tests/lanewise/test_kept_functions.py"
FITTING = f"{KEPT}::test_text_is_linked_with_other_callees_only_where_they_fit"

COMPILER = (
    Mutant(
        "an edited enumeration keeps its machine code",
        "source_digest.py",
        (("        if issubclass(kind, Enum):\n", "        if False:\n"),),
        "tests/lanewise/test_source_digest.py"
        "::test_a_digest_changes_with_what_the_kernel_sees[enumeration]",
        "lanewise",
    ),
    Mutant(
        "constants of nested modules are not read",
        "source_digest.py",
        (("            self.attributes(one, names, (*path, value))", "            pass"),),
        "tests/lanewise/test_source_digest.py"
        "::test_a_digest_changes_with_what_the_kernel_sees[module in a package]",
        "lanewise",
    ),
    Mutant(
        "kernels that raise are let pass",
        "kernel_text.py",
        (("(ast.Raise, ast.Assert, ast.Try)", "(ast.Assert, ast.Try)"),),
        "tests/lanewise/test_kernel_text.py"
        "::test_what_no_kernel_can_hold_is_refused_before_it_is_compiled[raises]",
        "lanewise",
    ),
    Mutant(
        "the remedy is looked for a line above",
        "kernel_text.py",
        (("    at = line - first + 1\n", "    at = line - first\n"),),
        "tests/lanewise/test_kernel_text.py"
        "::test_what_numba_cannot_type_is_told_with_line_and_remedy[chained]",
        "lanewise",
    ),
    Mutant(
        "constants that stay doubles",
        "numba_adapter.py",
        (("type(value.value) is float:", "type(value.value) is complex:"),),
        ADAPTER,
        "lanewise",
    ),
    Mutant(
        "Numba left as it is while kernels are compiled",
        "numba_shortcuts.py",
        (("            stack.callback(setattr, owner, name, getattr(owner, name))\n", ""),),
        "tests/lanewise/test_adapter.py::test_numba_is_as_before_when_a_kernel_fails",
        "lanewise",
    ),
    Mutant(
        "a kernel for every constant",
        "dispatchers.py",
        (("if keywords or plain == list(arguments):", "if True:"),),
        "tests/lanewise/test_compiler.py"
        "::test_a_kernel_is_compiled_once_for_all_numbers_unless_it_must_know_them",
        "lanewise",
    ),
    Mutant(
        "a stock pipeline that is the lean one",
        "jit.py",
        (("    if uses_stock_pipeline():\n", "    if uses_stock_pipeline() and False:\n"),),
        "tests/lanewise/test_pipelines.py::test_both_pipelines_give_the_same_bits",
        "lanewise",
    ),
    Mutant(
        "masks of wide packets that end after sixteen lanes",
        "simd.py",
        (('.tobytes(), "little")\n', '.tobytes(), "little") & 0xFFFF\n'),),
        "tests/lanewise/test_twins_lanes.py::test_every_lane_is_counted[256]",
        "lanewise",
    ),
    Mutant(
        "masks of bits that count from the other end",
        "simd.py",
        (('np.unpackbits(memory, bitorder="little")', 'np.unpackbits(memory, bitorder="big")'),),
        "tests/lanewise/test_twins_lanes.py::test_every_lane_is_counted[16]",
        "lanewise",
    ),
    Mutant(
        "samples of a packet that lie sixteen apart",
        "rendering/tiles/tile_kernel.py",
        (
            (
                "        taken[LANES + count] = as_uint(cursor.y)\n",
                "        taken[16 + count] = as_uint(cursor.y)\n",
            ),
        ),
        "tests/rendering/test_in_the_twin.py::test_wide_packets_give_the_bits_of_narrow_ones[glow]",
    ),
    Mutant(
        "machine code that outlives the compiler",
        "machine.py",
        (("_digest_of_sources({LANEWISE, package})", "_digest_of_sources({package})"),),
        "tests/determinism/test_kernel_cache.py::test_the_cache_folder_changes_with_any_callee",
        "lanewise",
    ),
    Mutant(
        "functions kept without what they call",
        "source_digest.py",
        (('        self.hash.update(f"{digest}\\0".encode())\n', ""),),
        "tests/lanewise/test_kept_functions.py"
        "::test_circumstances_closures_defaults_and_code_are_in_its_digest",
        "lanewise",
    ),
    Mutant(
        "functions kept for packets of any width",
        "machine.py",
        (('        "lanes": str(_native_lanes()),\n', ""),),
        f"{KEPT}::test_functions_are_kept_for_one_compiler_and_one_kind_of_code[lanes]",
        "lanewise",
    ),
    Mutant(
        "functions kept for processors of any features",
        "machine.py",
        (('        "features of the processor": llvm.get_host_cpu_features().flatten(),\n', ""),),
        f"{KEPT}::test_functions_are_kept_for_one_compiler_and_one_kind_of_code[features]",
        "lanewise",
    ),
    Mutant(
        "functions kept for any target",
        "machine.py",
        (("_compiler_name(_target)", "_compiler_name(NATIVE)"),),
        f"{KEPT}::test_functions_are_kept_for_one_compiler_and_one_kind_of_code[target]",
        "lanewise",
    ),
    Mutant(
        "functions kept without the values that they name",
        "source_digest.py",
        (("        self.globals(function)\n        for cell", "        for cell"),),
        "tests/lanewise/test_kept_functions.py::test_what_a_text_names_is_in_its_digest",
        "lanewise",
    ),
    Mutant(
        "functions kept without the kernels that they are given",
        "unlinked.py",
        (("isinstance(kind, types.Dispatcher)", "False"),),
        f"{KEPT}::test_a_kernel_that_is_given_to_another_is_part_of_what_is_kept",
        "lanewise",
    ),
    Mutant(
        "text linked with callees of other types",
        "unlinked.py",
        (("or _signature(answer) != call.signature", ""),),
        f"{FITTING}[another-type]",
        "lanewise",
    ),
    Mutant(
        "text linked with a record whose fields have changed places",
        "unlinked.py",
        (("map(description, (*answer.args", "map(str, (*answer.args"),),
        f"{KEPT}::test_text_is_not_linked_with_a_record_whose_fields_are_elsewhere",
        "lanewise",
    ),
    Mutant(
        "a root linked as if it were inlined somewhere",
        "unlinked.py",
        (("library.is_root = found.is_root", "library.is_root = False"),),
        f"{KEPT}::test_found_or_compiled_it_is_the_same_machine_code",
        "lanewise",
    ),
    Mutant(
        "what is inlined optimised at each step on the way",
        "numba_adapter.py",
        (("if self.is_root:", "if True:"),),
        f"{KEPT}::test_a_root_alone_is_optimised_as_a_whole",
        "lanewise",
    ),
    Mutant(
        "two kernels linked where there was one",
        "unlinked.py",
        (("if uses[id(kernel)] != 1 or", "if"),),
        f"{FITTING}[one-becomes-two]",
        "lanewise",
    ),
    Mutant(
        "one kernel linked where there were two",
        "unlinked.py",
        (
            ("    if len(set(symbols.values())) < len(symbols):\n        return None\n", ""),
            ('        assert symbol.name == name, f"two symbols are called {name}"\n', ""),
        ),
        f"{FITTING}[two-become-one]",
        "lanewise",
    ),
    Mutant(
        "kernels that take each other's places under old names",
        "unlinked.py",
        (('        symbol.name = f"lanewise.{number}"\n', "        pass\n"),),
        f"{FITTING}[swapped]",
        "lanewise",
    ),
    Mutant(
        "records that are told apart by their names alone",
        "unlinked.py",
        (("{getattr(record, '_fields', '')}", ""),),
        "tests/lanewise/test_kept_functions.py"
        "::test_fields_of_records_are_in_the_description_of_a_type",
        "lanewise",
    ),
    Mutant(
        "records blended the wrong way round",
        "record_instructions.py",
        (("b.select(mask, x, y)", "b.select(mask, y, x)"),),
        "tests/lanewise/test_records.py::test_one_bit_chooses_for_all_lanes[machine code]",
        "lanewise",
    ),
    Mutant(
        "a first field that is never replaced",
        "record_instructions.py",
        (("given.get(name, builder", "given.get(name if i else '', builder"),),
        "tests/lanewise/test_records.py::test_replace_changes_the_named_fields_only[machine code]",
        "lanewise",
    ),
    Mutant(
        "estimates of a vendor in portable code",
        "portable.py",
        (("set.add(function.attributes, _NO_ESTIMATES)", "pass"),),
        "tests/cluster/test_portable.py"
        "::test_portable_code_takes_no_instruction_whose_bits_are_a_vendors",
        "lanewise",
    ),
    Mutant(
        "portable packets as wide as this machine's",
        "machine.py",
        (("_PORTABLE_LANES if _target == PORTABLE else _native_lanes()", "_native_lanes()"),),
        "tests/lanewise/test_machine.py::test_portable_packets_are_as_wide_on_any_machine[16]",
        "lanewise",
    ),
)

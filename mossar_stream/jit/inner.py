"""Inner kernels: those that only other kernels call, compiled no further than their callers need.

numba optimises every kernel and makes machine code of it, then hands it on to each caller, which optimises the copy
again. Machine code of a kernel that Python never calls is never run, and what a caller is going to inline need not
be optimised before. So an inner kernel ends here where its code is generated; the entry point that calls it, with
all that is linked into it, is optimised once. That saves a third of the time to compile everything.
"""

from typing import Any

from numba.core.codegen import CPUCodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_machinery import LoweringPass, register_pass
from numba.core.typed_passes import AnnotateTypes, NativeLowering


class InnerLibrary(CPUCodeLibrary):
    """Code of one inner kernel and of those it calls, for its callers to link."""

    def _optimize_final_module(self) -> None:
        pass

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._verify_declare_only_symbols()
        self._finalized = True


@register_pass(mutates_CFG=False, analysis_only=True)
class _OpenLibrary(LoweringPass):
    """Let the code be generated into a library of our kind."""

    _name = "mossar_open_library"

    def __init__(self) -> None:
        super().__init__()

    def run_pass(self, state: Any) -> bool:
        state.library = InnerLibrary(state.targetctx.codegen(), state.func_id.func_qualname)
        return True


@register_pass(mutates_CFG=False, analysis_only=True)
class _MakeKnown(LoweringPass):
    """Let callers find the code, which numba sees to itself only where it makes machine code."""

    _name = "mossar_make_known"

    def __init__(self) -> None:
        super().__init__()

    def run_pass(self, state: Any) -> bool:
        name: Any = {}.update  # stands for what Python would call: a built-in method, and one of its own
        state.targetctx.insert_user_function(name, state["cr"].fndesc, [state.library])
        state["cr"] = state["cr"]._replace(cfunc=name)
        return True


class InnerCompiler(CompilerBase):
    """The usual pipeline, without machine code at its end."""

    def define_pipelines(self) -> list[Any]:
        """Return the one pipeline there is."""
        self.state.flags.no_compile = True
        pipeline = DefaultPassBuilder.define_nopython_pipeline(self.state)
        pipeline.add_pass_after(_OpenLibrary, AnnotateTypes)
        pipeline.add_pass_after(_MakeKnown, NativeLowering)
        pipeline.finalize()
        return [pipeline]

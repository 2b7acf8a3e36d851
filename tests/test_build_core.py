"""How the core is compiled: which compiler, which flags, what is out of date, and what is said where it cannot be."""

import shutil
import sys
import sysconfig

import pytest

from build_core import extensions, sources
from build_core.compiler import _multiarch_headers, commands, configured, flags_for


@pytest.mark.skipif(shutil.which("cc") is None, reason="there is no compiler")
def test_the_system_s_compiler_is_taken(monkeypatch):
    monkeypatch.delenv("CC", raising=False)
    assert configured() == sysconfig.get_config_var("CC")


def test_without_a_compiler_there_is_none(monkeypatch):
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setattr("sys.platform", "linux")
    assert configured({}.get) is None


def test_a_missing_compiler_is_one_line(monkeypatch):
    monkeypatch.setattr("build_core.compiler.configured", lambda: None)
    monkeypatch.setitem(sys.modules, "ziglang", None)
    with pytest.raises(
        SystemExit, match="There is no C compiler: install gcc or clang, or `pip install 'ziglang"
    ):
        commands()


def test_a_wish_that_is_not_there_is_said(monkeypatch):
    monkeypatch.setenv("CC", "no-such-cc -m64")
    with pytest.raises(SystemExit, match="CC=no-such-cc -m64: there is no such program"):
        configured()


def test_the_linker_is_the_compiler_with_the_options_of_python(monkeypatch):
    monkeypatch.setattr("sys.platform", "linux")
    monkeypatch.setenv("CC", "sh -x")
    monkeypatch.setattr(sysconfig, "get_config_var", {"LDSHARED": "gcc -shared -L/lib"}.get)
    assert commands() == {"CC": "sh -x", "LDSHARED": "sh -x -shared -L/lib"}


def test_zig_gets_no_option_of_a_distribution_for_linking(monkeypatch):
    monkeypatch.setattr("sys.platform", "linux")
    monkeypatch.setattr("build_core.compiler.configured", lambda: None)
    monkeypatch.setattr("build_core.compiler.zig_command", lambda: "zig cc")
    debian = {"LDSHARED": "x86_64-linux-gnu-gcc -shared -Wl,-Bsymbolic-functions -g"}
    monkeypatch.setattr(sysconfig, "get_config_var", debian.get)
    assert commands() == {"CC": "zig cc", "LDSHARED": "zig cc -shared"}


@pytest.mark.parametrize("is_debian", [True, False])
def test_zig_finds_the_headers_that_debian_keeps_outside_of_python_s_folder(tmp_path, monkeypatch, is_debian):
    folder = tmp_path / "include" / "python3.11"
    for place in (folder, tmp_path / "include" / "x86_64-linux-gnu" / "python3.11"):
        if is_debian or place == folder:
            place.mkdir(parents=True)
            (place / "pyconfig.h").touch()
    monkeypatch.setattr(sysconfig, "get_config_var", {"MULTIARCH": "x86_64-linux-gnu"}.get)
    monkeypatch.setattr(sysconfig, "get_paths", lambda: {"include": str(folder)})
    wanted = ["-idirafter", str(tmp_path / "include")] if is_debian else []
    assert _multiarch_headers() == wanted


def test_no_extension_is_for_the_processor_of_this_machine(monkeypatch):
    monkeypatch.setattr("sys.platform", "linux")
    monkeypatch.setattr("platform.machine", lambda: "x86_64")
    flags = {"is_sanitized": False}
    assert flags_for("baseline", "gcc", **flags)[-1] == "-march=x86-64"
    assert flags_for("x86_64_v3", "gcc", **flags)[-1] == "-march=x86-64-v3"
    assert flags_for("baseline", "/x/ziglang/zig cc", **flags)[-1] == "-mcpu=baseline"
    assert flags_for("x86_64_v3", "/x/ziglang/zig cc", **flags)[-1] == "-mcpu=x86_64_v3"
    assert flags_for("x86_64_v3", "", **flags) == ["/O2", "/fp:precise", "/arch:AVX2"]
    monkeypatch.setattr("platform.machine", lambda: "aarch64")
    assert not [flag for flag in flags_for("baseline", "gcc", **flags) if flag.startswith("-m")]
    assert extensions.variants() == ["baseline"]


def test_warnings_are_no_part_of_the_recipe_so_a_strict_build_is_up_to_date_afterwards(monkeypatch):
    if configured() is None:
        pytest.importorskip("ziglang", reason="there is no compiler")
    made = []
    monkeypatch.setattr(extensions, "run_each", lambda words, _environment: made.append(words))
    monkeypatch.setattr(extensions, "is_built_from", lambda _path, text: texts.append(text) or True)
    texts = []
    assert not any(extensions.build().values())
    assert all(extensions.build(is_strict=True).values())
    usual, strict = made
    assert not usual
    assert {words[0] for words in strict} == {"--strict"}
    if "CC" in commands():
        assert all("-Werror" in words for words in strict)
    assert len(set(texts)) == len(extensions.variants())


def test_missing_headers_are_named(monkeypatch):
    monkeypatch.setattr(sysconfig, "get_paths", lambda: {"include": "/nowhere"})
    with pytest.raises(
        SystemExit, match=r"^There is no .*Python\.h: install Python's headers \(python3-dev\), or a wheel\.$"
    ):
        extensions.build()


def test_an_extension_is_out_of_date_when_a_source_or_the_recipe_has_changed(tmp_path, monkeypatch):
    monkeypatch.setattr(sources, "PACKAGE", tmp_path)
    (tmp_path / "a.pxi").write_text("1")
    built = sources.built_from("cc", "-O3")
    extension = tmp_path / "core.so"
    assert not sources.is_built_from(extension, built)
    extension.write_bytes(b"\0" + built.encode() + b"\n\0")
    assert sources.is_built_from(extension, built)
    assert not sources.is_built_from(extension, sources.built_from("cc", "-O2"))
    (tmp_path / "b.h").write_text("2")
    assert not sources.is_built_from(extension, sources.built_from("cc", "-O3"))


def test_structs_of_numbers_and_such_structs_are_told_to_python(tmp_path, monkeypatch):
    monkeypatch.setattr(sources, "PACKAGE", tmp_path)
    (tmp_path / "a.pxi").write_text(
        "cdef struct Point:  # somewhere\n"
        "    float at[3]  # m\n"
        "\n"
        "    # Which one.\n"
        "    int32_t joint\n"
        "\n\n"
        "cdef struct Span:\n"
        "    Point* at\n"
        "cdef double ZERO = 0.0\n"
        "cdef struct Foot:\n"
        "    Point places[4]\n"
    )
    assert sources.records() == "Point float at[3]; int32_t joint\nFoot Point places[4]"


def test_a_quick_build_differs_in_the_level_of_optimisation_alone():
    flags = {"is_sanitized": False}
    usual, quick = (flags_for("baseline", "gcc", **flags, is_quick=quick) for quick in (False, True))
    assert set(usual) ^ set(quick) == {"-O3", "-O1"}

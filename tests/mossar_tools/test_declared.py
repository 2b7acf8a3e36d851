import argparse
from typing import Annotated, Literal

import msgspec
import pytest

from mossar_tools.cli import COMMANDS, command_called
from mossar_tools.declared import Option, Section, add_options, declared, nested, operand, values_of


class Place(msgspec.Struct, frozen=True):
    port: Annotated[int, Section("the page"), Option("port of it", "N", int)] = 8080
    at_once: Annotated[bool, Option("open it at once")] = False


class Options(msgspec.Struct, frozen=True):
    sources: Annotated[tuple[str, ...], operand("SOURCE", "what is read", "*")] = ()
    place: Place = Place()
    to: Annotated[tuple[str, ...], Option("sinks", "SINK", repeatable=True)] = ()
    kind: Annotated[Literal["a", "b"] | None, Section("more"), Option("which", flag="of")] = None
    mirrored: Annotated[bool | None, Option("both sides")] = None


def read(*arguments):
    parser = argparse.ArgumentParser(argument_default=argparse.SUPPRESS)
    add_options(parser, Options)
    return msgspec.convert(nested(Options, vars(parser.parse_args(arguments))), Options)


def test_options_that_are_not_given_have_the_defaults_of_the_record():
    assert read() == Options()


def test_values_go_to_their_fields_also_in_groups():
    found = read("x", "y", "--port", "3", "--at-once", "--to", "p", "--to", "q", "--of", "b", "--no-mirrored")
    assert found == Options(("x", "y"), Place(3, at_once=True), ("p", "q"), "b", mirrored=False)
    assert values_of(found)["port"] == 3


def test_a_literal_says_the_choices(capsys):
    with pytest.raises(SystemExit):
        read("--of", "c")
    assert "choose from 'a', 'b'" in capsys.readouterr().err


def test_a_section_goes_up_to_the_next_one_or_the_end_of_its_record():
    sections = {one.name: one.section for one in declared(Options)}
    assert sections == {
        "sources": "",
        "port": "the page",
        "at_once": "the page",
        "to": "",
        "kind": "more",
        "mirrored": "more",
    }


@pytest.mark.parametrize("command", COMMANDS)
def test_names_of_a_command_s_options_are_different(command):
    names = [one.name for one in declared(command_called(command).Options)]
    assert len(set(names)) == len(names)
    assert {"quiet", "verbose", "log_level", "log_json"} <= set(names)


@pytest.mark.parametrize("command", COMMANDS)
def test_what_is_declared_has_a_hash_by_which_msgspec_finds_types(command):
    assert all(isinstance(hash(one.option), int) for one in declared(command_called(command).Options))

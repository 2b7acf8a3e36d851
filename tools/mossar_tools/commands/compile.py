"""`mossar compile`: all kernels, before they are needed."""

import argparse
from functools import partial
from typing import get_args

import mossar_stream
from mossar_stream import Settings, SimilarityName
from mossar_tools.compiling import Compiling
from mossar_tools.console import LOGGER, Console
from mossar_tools.errors import DONE
from mossar_tools.options import Options, add_messages
from mossar_tools.signals import interruptibly

DESCRIPTION = """Compile the kernels of all presets, levels and options. Other commands compile the kernels that they need at
their first start; after this command they start at once. Once for each installation."""
EXAMPLES = """  mossar compile                 when an image is built, or before a show
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of this command."""
    add_messages(parser)


def run(_options: Options, _console: Console) -> int:
    """Run the command and return the exit status."""
    said = Compiling()
    names = get_args(SimilarityName)
    with mossar_stream.on_first_compile(said.begin):
        for place, name in enumerate(names):
            settings = Settings(similarity=name, limbs=True, repetitions=True, steps=True)
            progress = partial(_log_part, said, place, len(names))
            precompile = partial(mossar_stream.precompile, settings, moves=True, recordings=True)
            interruptibly(partial(precompile, progress=progress))
    said.end()
    if not said.is_cold:
        LOGGER.info("all kernels were compiled before")
    return DONE


def _log_part(said: Compiling, place: int, measures: int, part: str, done: int, parts: int) -> None:
    """Tell of a part of one similarity measure as one of all parts of all measures."""
    said.part(part, place * parts + done, measures * parts)

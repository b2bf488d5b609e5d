"""The command line.

Exit status: 0; 2 for a mistake in the input; 1 for a failed run; 130 for an interrupt, 143 for SIGTERM, 129 for SIGHUP;
141 where nobody reads on.
"""

from __future__ import annotations

import os
import signal
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NoReturn

import typer
from rich.console import Console
from rich.table import Table
from rich.text import Text

from porous_swim.core import process_limits as limits
from porous_swim.core.console import fill_closed_streams, printable, silence, tell
from porous_swim.core.errors import DeviceError, PorousSwimError, ResultsError, RunError, SceneError
from porous_swim.core.machine import bound_libraries, usable_processors
from porous_swim.running.interrupts import exit_status, fatal

if TYPE_CHECKING:
    from porous_swim.scene.scene import Scene

app = typer.Typer(
    help="Microswimmers among colloids: capture, orbits, hops and transport in porous media.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)
ADDRESS_SPACE = dict.fromkeys(("run", "check", "reproduce", "bench"), limits.FOR_A_RUN) | dict.fromkeys(
    ("report", "theory"), limits.FOR_TABLES
)  # what starts none of these commands needs no libraries
WARNING = "warning"  # its label
Json = Annotated[bool, typer.Option("--json", help="For machines.")]
SceneFile = Annotated[Path, typer.Argument(metavar="SCENE", help="A scene file, such as scenes/crystal.yaml.")]
Changes = Annotated[
    list[str] | None,
    typer.Option(
        "--set", metavar="KEY=VALUE", help="Change a key, such as swimmers.dipole_strength=0.8; may be repeated."
    ),
]


def main() -> None:
    """Run the command line and leave with its exit status."""
    fill_closed_streams()
    try:
        try:
            _command()
        finally:
            if sys.stdout is not None:  # closed by the caller
                sys.stdout.flush()
    except SystemExit as left:
        if isinstance(left.__context__, BrokenPipeError):  # typer makes status 1 of it, that of a run that failed
            _reader_gone()
        raise
    except BrokenPipeError:
        _reader_gone()
    except OSError as error:
        silence(sys.stdout)
        _leave(f"{error.filename or 'output'}: {error.strerror or error}", 1)


def _command() -> None:
    try:
        if sys.argv[1:2] and sys.argv[1] in ADDRESS_SPACE:
            limits.require(address=ADDRESS_SPACE[sys.argv[1]], threads=limits.OTHER_THREADS + 2)
        app()
    except (SceneError, ResultsError, DeviceError) as error:
        _leave(error, 2)
    except RunError as error:
        _leave(error, 1)
    except KeyboardInterrupt as interrupt:
        sys.exit(128 + (interrupt.args[0] if interrupt.args else signal.SIGINT))
    except MemoryError:
        _leave("not enough memory: lower swimmers.count or record.swimmers", 2)


def _reader_gone() -> NoReturn:
    """Nothing to say, and nobody to say it to; the status is what shells give for tools that SIGPIPE ends."""
    silence(sys.stdout)
    sys.exit(141)


def _leave(error: PorousSwimError | str, status: int) -> NoReturn:
    tell(str(error), sys.stderr)
    sys.exit(status)


def _show_version(wanted: bool) -> None:
    if wanted:
        from porous_swim import __version__

        print(f"porous-swim {__version__}")
        raise typer.Exit


@app.callback()
def _every_command(
    version: Annotated[
        bool, typer.Option("--version", callback=_show_version, is_eager=True, help="Say the version and leave.")
    ] = False,
) -> None:
    pass


@app.command()
def run(
    scene: SceneFile,
    out: Annotated[Path | None, typer.Option(help="The run folder. Default: runs/NAME, runs/NAME-2, ...")] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace an earlier run in --out.")] = False,
    seed: Annotated[int | None, typer.Option(help="Instead of run.seed.")] = None,
    changes: Changes = None,
    device: Annotated[
        str | None, typer.Option(help="auto, cpu, cuda, vulkan or metal; auto never takes vulkan.")
    ] = None,
    precision: Annotated[str | None, typer.Option(help="auto, f32 or f64.")] = None,
    threads: Annotated[int | None, typer.Option(help="Threads of the CPU.")] = None,
    no_recording: Annotated[bool, typer.Option("--no-recording", help="Write tables only.")] = False,
    quiet: Annotated[bool, typer.Option("--quiet", help="No progress and no summary.")] = False,
    json_: Annotated[
        bool, typer.Option("--json", help="Folder and summary for machines on stdout, and nothing else there.")
    ] = False,
    force_memory: Annotated[
        bool, typer.Option("--force-memory", help="Start even where memory is expected not to suffice.")
    ] = False,
) -> None:
    """Run a scene. The last line on stdout is the run folder."""
    bound_libraries(threads or usable_processors())
    with fatal():
        from porous_swim.results.run_folder import RunFolder
        from porous_swim.running.run import run_in

    options = {"run.seed": seed, "run.device": device, "run.precision": precision, "run.threads": threads}
    loaded = _scene(scene, changes, {key: value for key, value in options.items() if value is not None})
    results = run_in(
        lambda: (
            RunFolder.next_free(loaded.name)
            if out is None
            else RunFolder.at(
                out, overwrite=force, inputs=loaded.inputs, hint="--force", say=lambda line: tell(line, sys.stderr)
            )
        ),
        scene=loaded,
        progress=not quiet,
        recording=not no_recording,
        force_memory=force_memory,
    )
    assert results.folder is not None
    shown = os.path.relpath(results.folder) if out is None or _is_relative(out) else str(results.folder)
    if json_:
        _print_json({"folder": shown} | results.summary)
    else:
        if not quiet:
            _print_summary(results.summary)
        print(shown)
    if results.summary["status"] == "interrupted":
        time, units = results.info.last_time, results.info.units
        laboratory = f" ({time * units['time_s']:.4g} s)" if units else ""
        tell(f"interrupted at time {time:g} a/U{laboratory}; what was seen until then is kept", sys.stderr)
        raise typer.Exit(exit_status(results.summary["signal"]))


@app.command(short_help="Say what a scene is, what it costs, and what to mind.")
def check(scene: SceneFile, changes: Changes = None, json_: Json = False) -> None:
    """Say what a scene is, what it costs, and what to mind about it; run nothing."""
    from porous_swim.commands.check import describe
    from porous_swim.commands.facts import facts_of

    loaded = _scene(scene, changes, {})
    if json_:
        _print_json(facts_of(loaded))
    else:
        _print_rows(describe(loaded))


@app.command()
def view(
    run_folder: Annotated[Path, typer.Argument(metavar="RUN", help="A run folder.")],
    web: Annotated[bool, typer.Option("--web", help="In the browser.")] = False,
) -> None:
    """Open the recording of a run in the Rerun viewer."""
    recording = run_folder / "recording.rrd"
    if not run_folder.is_dir():
        raise ResultsError(f"{run_folder}: there is no such run folder")
    if not recording.is_file():
        raise ResultsError(f"{run_folder}: there is no recording.rrd in it")
    if not web and sys.platform == "linux" and not {"DISPLAY", "WAYLAND_DISPLAY"} & set(os.environ):
        raise ResultsError("view: there is no display here; --web opens the recording in a browser")
    viewer = [sys.executable, "-m", "rerun", str(recording)]
    os.execve(sys.executable, [*viewer, "--web-viewer", "--bind", "127.0.0.1"] if web else viewer, _without_analytics())


def _without_analytics() -> dict[str, str]:
    """The environment of a viewer that tells nobody about its use, whatever its user's settings say.

    Rerun sends usage statistics from the second start on, but never where `CI` is set: its one switch by environment.
    """
    kept = {name: value for name, value in os.environ.items() if name != "FORCE_RERUN_ANALYTICS"}
    return {**kept, "CI": kept.get("CI", "1")}


@app.command(short_help="Write pictures and tables of a run as one HTML page.")
def report(
    run_folder: Annotated[Path, typer.Argument(metavar="RUN", help="A run folder.")],
    compare: Annotated[
        list[Path] | None, typer.Option(metavar="RUN2", help="A run to lay over it; may be repeated.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="Folder for page and pictures. Default: RUN/report, or RUN/comparison.")
    ] = None,
) -> None:
    """Summarise a run, and write pictures and tables as one HTML page. The last line on stdout is its path."""
    from porous_swim.reporting.terminal import print_report
    from porous_swim.reporting.write import write_report
    from porous_swim.results.loading import load_results
    from porous_swim.results.manifest import REPORTS

    every = [load_results(folder) for folder in (run_folder, *(compare or []))]
    made = write_report(every, out or run_folder / REPORTS[1 if compare else 0])
    print_report(made)
    print(made.page)


@app.command()
def new(
    name: Annotated[str, typer.Argument(metavar="NAME", help="The new file: NAME.yaml.")],
    template: Annotated[str, typer.Option("--from", help="A scene that ships with porous_swim.")] = "crystal",
) -> None:
    """Write a scene file to start from."""
    from porous_swim.scene.shipped import copy_template

    print(copy_template(template, Path(name)))


@app.command(short_help="Print what theory predicts for one swimmer at one colloid.")
def theory(
    dipole_strength: Annotated[float, typer.Option(help="alpha: above 0 a pusher, below 0 a puller.")],
    aspect_ratio: Annotated[float, typer.Option(help="gamma, minor over major axis; 1 is a sphere.")] = 1.0,
    radius: Annotated[
        float | None, typer.Option(help="A, of the colloid, in swimmer half-lengths; inf is a plane wall.")
    ] = None,
    diffusion: Annotated[float | None, typer.Option(help="D in a U, with D_r = 3 D/4; needs --radius.")] = None,
    json_: Json = False,
) -> None:
    """Print what theory predicts for one swimmer at one colloid: capture, sliding, scattering, trapping."""
    from porous_swim.commands.theory import predictions

    if diffusion is not None and radius is None:
        raise SceneError("theory: --diffusion needs a --radius")
    rows = predictions(dipole_strength, aspect_ratio, radius, diffusion)
    if json_:
        _print_json([row.as_dict() for row in rows])
    else:
        _print_rows([(f"{row.quantity} ({row.order})", row.text) for row in rows])


@app.command(short_help="Make the figures of Spagnolie et al. (2015) again.")
def reproduce(
    names: Annotated[
        list[str] | None, typer.Argument(metavar="[NAME]...", help="Figures; all if none is named.")
    ] = None,
    quick: Annotated[bool, typer.Option("--quick", help="Reduced counts: all figures in minutes.")] = False,
    out: Annotated[Path, typer.Option(help="Folder for data, pictures and the comparison.")] = Path("reproduce"),
) -> None:
    """Make the figures of Spagnolie et al., Soft Matter 11, 3396 (2015), again: data, pictures, ours against theirs."""
    from porous_swim.paper.report import reproduce as make

    paper, independent = make(names or [], out, quick=quick)
    print(f"against the paper {paper}; against the independent program {independent}: see {out / 'comparison.md'}")
    raise typer.Exit(1 if independent.n_differ else 0)


@app.command(short_help="Measure the speed of the engine.")
def bench(
    names: Annotated[
        list[str] | None, typer.Argument(metavar="[NAME]...", help="Groups of figures; all if none is named.")
    ] = None,
    quick: Annotated[bool, typer.Option("--quick", help="Tiny counts: whether it works, not how fast.")] = False,
    json_: Json = False,
) -> None:
    """Measure the speed of the engine: ratios to C that does the same job, and to itself. Takes minutes."""
    from porous_swim.bench.report import benchmark, text

    found = benchmark(names or [], quick=quick)
    if json_:
        _print_json(found)
    else:
        print(text(found))


@app.command(short_help="Print the JSON Schema of scene files, for editors.")
def schema(
    page: Annotated[bool, typer.Option("--page", help="A reference page in Markdown instead, for people.")] = False,
) -> None:
    """Print the JSON Schema of scene files, for editors; it knows the keys of installed plug-ins."""
    from porous_swim.scene.schema import json_schema, scene_page

    if page:
        print(scene_page(), end="")
    else:
        _print_json(json_schema())


def _print_json(data: object) -> None:
    import json

    print(json.dumps(data, indent=2))


def _is_relative(path: Path) -> bool:
    return not path.is_absolute() and not str(path).startswith("~")


def _print_summary(summary: dict[str, Any]) -> None:
    from porous_swim.analysis.summary import summary_lines

    rows = [(label, text) for label, _, text in (line.partition(": ") for line in summary_lines(summary))]
    _print_rows([row for row in rows if row[0] != WARNING])
    _print_rows([row for row in rows if row[0] == WARNING])


def _print_rows(rows: list[tuple[str, str]]) -> None:
    """Two columns; on a terminal long texts are wrapped inside theirs."""
    console = Console(highlight=False)
    rows = [(label, printable(text)) for label, text in rows]
    if not console.is_terminal:
        width = max((len(label) for label, _ in rows), default=0)
        for label, text in rows:
            print(f"{label:<{width}}  {text}")
        return
    table = Table.grid(padding=(0, 2, 0, 0))
    for label, text in rows:
        table.add_row(Text(label, style="yellow" if label == WARNING else "bold"), Text(text))
    console.print(table)


def _scene(path: Path, changes: list[str] | None, options: dict[str, object]) -> Scene:
    from porous_swim.scene.document import read_value
    from porous_swim.scene.scene import load_scene

    for change in changes or []:
        key, equals, value = change.partition("=")
        if not equals or not key:
            raise SceneError(f"--set {change}: expected KEY=VALUE, such as swimmers.dipole_strength=0.8")
        try:
            options[key] = read_value(value)
        except SceneError as error:
            raise SceneError(f"--set {change}: {error}") from None
    return load_scene(path, options)

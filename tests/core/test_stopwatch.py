"""The line that says where the time of a run went."""

from porous_swim.core.stopwatch import Stopwatch


def test_parts_are_counted_by_name_and_add_up():
    now = 0.0
    watch = Stopwatch(lambda: now)
    for what, seconds in (("swimming", 2.0), ("recording", 0.5), ("swimming", 1.0)):
        with watch.timing(what):
            now += seconds
        now += 10.0  # between the parts
    assert watch.line() == "took 3.5 s: swimming 3.0 s, recording 0.5 s"

"""Jobs come in order, the last of a name only, and background ones at the end."""

from threading import Timer

from pipeline.show.jobs import Jobs


def test_the_last_of_a_name_is_done() -> None:
    """Of jogs that were not begun only the last is left; buttons are never dropped."""
    jobs, done = Jobs("map"), []
    jobs.post("map", lambda: done.append("map"))
    for k in range(3):
        jobs.post("jog", lambda k=k: done.append(f"jog {k}"))
        jobs.post_every(lambda k=k: done.append(f"click {k}"))
    while (job := jobs.take(0.0)) is not None:
        job()
    assert done == ["jog 2", "click 0", "click 1", "click 2", "map"]


def test_waiting_ends_with_a_job() -> None:
    """A job from another thread wakes whoever waits."""
    jobs, done = Jobs(), []
    timer = Timer(0.05, lambda: jobs.post("late", lambda: done.append("late")))
    timer.start()
    job = jobs.take(30.0)
    assert job is not None
    job()
    assert done == ["late"]

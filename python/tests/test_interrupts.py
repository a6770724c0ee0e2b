"""Work can be ended from Python."""

import signal
import threading

import pytest

import haptic_camera as hc


def test_ctrl_c_ends_a_diagnosis(captures: list[hc.Capture]) -> None:
    def interrupt(_: hc.Progress) -> None:
        signal.raise_signal(signal.SIGINT)

    threads = threading.active_count()
    with pytest.raises(KeyboardInterrupt):
        hc.diagnose(captures[0], captures[1], progress=interrupt)
    assert threading.active_count() == threads


def test_what_a_callback_raises_ends_a_diagnosis(captures: list[hc.Capture]) -> None:
    def fail(progress: hc.Progress) -> None:
        raise RuntimeError(progress.effect)

    with pytest.raises(RuntimeError):
        hc.diagnose(captures[0], captures[1], progress=fail)


def test_the_interpreter_goes_on_while_a_diagnosis_is_made(captures: list[hc.Capture]) -> None:
    done, counted = threading.Event(), 0

    def work() -> None:
        hc.diagnose(captures[0], captures[1])
        done.set()

    worker = threading.Thread(target=work)
    worker.start()
    while not done.wait(0.001):
        counted += 1
    worker.join()
    assert counted > 10


def test_ctrl_c_ends_a_fit(captures: list[hc.Capture]) -> None:
    timer = threading.Timer(0.005, signal.raise_signal, [signal.SIGINT])
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        hc.fit([captures[0]] * 100)

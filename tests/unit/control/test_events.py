"""What happens whatever the controller wants."""

import numpy as np

from turbine_fenicsx.control.events import Event, Orders, supervise
from turbine_fenicsx.control.interface import Commands, Measurements

WANTED = Commands(4e4, (0.1, 0.1, 0.1), 0.01)
DT = 0.1


def follow(events, times, pitch=0.1):
    """Orders at each of some times, wanted being the same always."""
    found, orders = [], Orders(0.0, (pitch,) * 3)
    for k, time in enumerate(times):
        measured = Measurements(time, DT, k == 0, 120.0, 1.2, 0.0, (pitch,) * 3, 0.0, 0.0)
        orders = supervise(events, measured, WANTED, orders)
        found.append(orders)
    return found


def test_without_events_all_is_done_as_wanted():
    (orders,) = follow([], [3.0])
    assert orders == Orders(WANTED.generator_torque, WANTED.pitch, WANTED.yaw_rate)


def test_a_stop_turns_the_blades_at_its_rate_and_no_further():
    events = [Event(1.0, "shut_down", pitch=0.5, rate=1.0), Event(1.0, "grid_loss")]
    orders = follow(events, DT * np.arange(30))
    before, after = orders[9], orders[10]
    assert before.pitch == WANTED.pitch and before.generator_torque == 4e4
    assert np.allclose(after.pitch, 0.2) and after.generator_torque == 0.0
    assert orders[-1].pitch == (0.5, 0.5, 0.5)


def test_a_blade_with_a_fault_stays_where_it_was_told_to_be():
    events = [Event(0.5, "pitch_fault", blade=2), Event(0.5, "emergency_stop", pitch=1.5, rate=9.0)]
    last = follow(events, DT * np.arange(30))[-1]
    assert last.pitch == (1.5, 0.1, 1.5)


def test_a_start_up_waits_and_then_follows_at_its_rate_until_it_has_caught_up():
    orders = follow([Event(1.0, "start_up", rate=2.0)], DT * np.arange(30), pitch=1.5)
    assert orders[9].pitch == (1.5, 1.5, 1.5) and orders[9].generator_torque == 0.0
    assert np.allclose(orders[10].pitch, 1.3) and orders[10].generator_torque == 4e4
    assert orders[-1].pitch == WANTED.pitch and orders[-1].started


def test_the_brake_closes_in_its_time():
    strength = [x.brake for x in follow([Event(1.0, "brake", duration=0.5)], DT * np.arange(20))]
    assert strength[10] == 0.0 and np.isclose(strength[12], 0.4) and strength[-1] == 1.0
    at_once = follow([Event(1.0, "brake", duration=0.0)], [0.9, 1.0])
    assert [x.brake for x in at_once] == [0.0, 1.0]

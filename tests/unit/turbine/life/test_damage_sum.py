"""Damage of runs, added up by how often they happen."""

import numpy as np

from turbine_fenicsx.materials.ply_damage import PlyDamage
from turbine_fenicsx.turbine.life.damage_sum import DamageSum


def test_sums_know_the_run_and_the_winds_that_do_most():
    total = DamageSum((3,))
    runs = [
        (10.0, 8.0, (1.0, 0.0, 3.0), (1.0, -1.0, 2.0)),
        (5.0, 12.0, (4.0, 0.0, 1.0), (1.0, -1.0, 1.0)),
        (1.0, 8.0, (7.0, 0.0, 9.0), (1.0, 0.0, 1.0)),
    ]
    for k, (times, wind, damage, cycles) in enumerate(runs):
        found = PlyDamage(np.array(damage), np.array(cycles), 2.0 * np.array(damage))
        total.add(k, times, wind, found)
    assert total.damage.tolist() == [37.0, 0.0, 44.0]
    assert total.worst.tolist() == [1, 0, 0]
    assert total.range.tolist() == [14.0, 0.0, 18.0]
    assert total.counted.tolist() == [True, False, True]
    assert {wind: x.tolist() for wind, x in total.of_winds.items()} == {
        8.0: [17.0, 0.0, 39.0],
        12.0: [20.0, 0.0, 5.0],
    }

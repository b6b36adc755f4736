"""Times in which a robot is far from its believed pose."""

from benchmarks.chaos.message_checks import FAR, Gap, Strays


def test_a_robot_is_astray_from_its_first_far_pose_until_the_next_near_one() -> None:
    strays = Strays()
    for now, metres in enumerate((0.1, FAR, 5.0, 0.3, 0.2, 2.0)):
        strays.look(metres, float(now))
    assert strays.gaps == [Gap(1.0, 3.0)]
    strays.end(9.0)
    strays.end(10.0)
    assert strays.gaps == [Gap(1.0, 3.0), Gap(5.0, 9.0)]

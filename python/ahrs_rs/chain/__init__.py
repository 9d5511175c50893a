"""Chains of segments with a sensor each: joints, their axes and angles, headings and clocks.

The angle of a hinge from two recordings:

>>> import numpy as np
>>> import ahrs_rs as ar
>>> thigh = ar.simulate.demo(duration=20.0, seed=1)
>>> shank = ar.Recording(t=thigh.t + 3.21, gyr=thigh.gyr, acc=thigh.acc)  # the same segment, by another clock
>>> clock = ar.chain.synchronise(thigh, shank)
>>> round(clock.offset, 3)
-3.21

A **segment** is a rigid body, such as a thigh or a link of a robot; each has one sensor. A relative orientation rotates
from the frame of the second sensor to that of the first, ``r = q_first* ⊗ q_second``. Axes of joints are unit vectors
in the frame of a sensor. Estimates without a magnetometer have a heading of their own each, which drifts apart;
`correct_heading` finds by what the joint cannot do how far. All of it is plain numpy over whole recordings.
"""

from ahrs_rs.chain._alignment import FunctionalAxis, SegmentAlignment, align_by_motion, align_by_pose, functional_axis
from ahrs_rs.chain._clock import ClockOffset, synchronise
from ahrs_rs.chain._heading import HeadingCorrection, correct_heading
from ahrs_rs.chain._hinge import HingeAxis, hinge_axis
from ahrs_rs.chain._joints import Ball, Hinge, Joint, Universal
from ahrs_rs.chain._relative import JointAngle, Relative, joint_angle, relative

__all__ = [
    "Ball",
    "ClockOffset",
    "FunctionalAxis",
    "HeadingCorrection",
    "Hinge",
    "HingeAxis",
    "Joint",
    "JointAngle",
    "Relative",
    "SegmentAlignment",
    "Universal",
    "align_by_motion",
    "align_by_pose",
    "correct_heading",
    "functional_axis",
    "hinge_axis",
    "joint_angle",
    "relative",
    "synchronise",
]

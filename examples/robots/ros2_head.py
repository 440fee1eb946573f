#!/usr/bin/env python3
"""practice_head.py with the joints of a ROS 2 robot: docs/external_robots.md. Untried: no ROS 2 was at hand.
It publishes std_msgs/Float64MultiArray (ros2_control's forward_command_controller) and reads sensor_msgs/JointState.
The ball is still simulated; a camera of one's own, such as metavision_camera.py's, takes the place of BallCamera.
usage: ros2_head.py ADDRESS [COMMANDS [STATES]]    ADDRESS as of practice_head.py; topics, by default /head_controller/commands
and /joint_states"""
import sys, threading, time

import rclpy
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray

import practice_head

STALE_S = 0.1
NAMES = [name.decode() for name, _, _ in practice_head.JOINTS]


class RosJoints:
    def __init__(self, commands, states):
        self.node = rclpy.create_node("saccade_head")
        self.commands = self.node.create_publisher(Float64MultiArray, commands, 1)
        self.node.create_subscription(JointState, states, self.take, 10)
        self.lock, self.position, self.read = threading.Lock(), [0.0] * len(NAMES), [float("-inf")] * len(NAMES)
        threading.Thread(target=rclpy.spin, args=(self.node,), daemon=True).start()
        end = time.monotonic() + 5.0
        while min(self.read) < 0.0:
            if time.monotonic() > end:
                sys.exit(f"ros2_head.py: found no positions of {', '.join(NAMES)} on {states} in 5 s")
            time.sleep(0.01)

    def take(self, message):
        with self.lock:
            for name, position in zip(message.name, message.position):
                if name in NAMES:
                    self.position[NAMES.index(name)] = position
                    self.read[NAMES.index(name)] = time.monotonic()

    def move(self, reference, dt):
        """A joint without a position for STALE_S is not sound. Nothing is commanded before time passes."""
        if dt > 0.0:
            self.commands.publish(Float64MultiArray(data=list(reference)))
        with self.lock:
            return self.position[:], [time.monotonic() - read < STALE_S for read in self.read]


if __name__ == "__main__":
    rclpy.init()
    topics = sys.argv[2:] + ["/head_controller/commands", "/joint_states"][len(sys.argv) - 2:]
    practice_head.serve(sys.argv[1], RosJoints(*topics[:2]), practice_head.BallCamera())

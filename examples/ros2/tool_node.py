"""A ROS 2 simulator as the physics of Tactor: `tactor bridge` gives the steps, topics carry the force and the tool's state."""
import json
import sys
import threading

import numpy as np
import rclpy
import websocket
from geometry_msgs.msg import WrenchStamped
from nav_msgs.msg import Odometry
from rclpy.qos import qos_profile_sensor_data


def tool_of(odometry):
    """The tool of a result: the pose as it is, the twist turned from the tool's frame into the world."""
    p, q, twist = odometry.pose.pose.position, odometry.pose.pose.orientation, odometry.twist.twist
    axis = np.array([q.x, q.y, q.z])
    v, w = (u + 2 * np.cross(axis, np.cross(axis, u) + q.w * u)
            for u in (np.array([v.x, v.y, v.z]) for v in (twist.linear, twist.angular)))
    return {"p_WT": [p.x, p.y, p.z], "R_WT": [q.w, q.x, q.y, q.z], "v_WT": v.tolist(), "w_WT": w.tolist()}


def wrench_of(step, tool, stamp):
    """The coupling's force on the tool, in the world."""
    coupling, handle, message = step["coupling"], step["handle"], WrenchStamped()
    message.header.stamp, message.header.frame_id = stamp, "world"
    message.wrench.force.x, message.wrench.force.y, message.wrench.force.z = (
        coupling["k_t"] * (p_D - p) + coupling["b_t"] * (v_D - v)
        for p_D, p, v_D, v in zip(handle["p_WD"], tool["p_WT"], handle["v_WD"], tool["v_WT"]))
    return message


rclpy.init()
node, newest, told = rclpy.create_node("tactor_tool"), [None], None
node.create_subscription(Odometry, "tool/odometry", lambda message: newest.__setitem__(0, message), qos_profile_sensor_data)
force = node.create_publisher(WrenchStamped, "tool/wrench", 1)
threading.Thread(target=rclpy.spin, args=(node,), daemon=True).start()
address, token = sys.argv[1].split("#")
bridge = websocket.create_connection(address, subprotocols=["tactor.bridge", f"token.{token}"])
while text := bridge.recv():  # empty once the bridge has closed
    step = json.loads(text)
    if step["type"] == "error":
        node.get_logger().warning(step["message"])
    elif step["type"] == "step" and newest[0] is told:  # the simulator has told nothing new
        bridge.send('{"type": "next"}')
    elif step["type"] == "step":
        told = newest[0]
        tool = tool_of(told)
        force.publish(wrench_of(step, tool, node.get_clock().now().to_msg()))
        bridge.send(json.dumps({"type": "result", "id": step["id"], "tool": tool}))

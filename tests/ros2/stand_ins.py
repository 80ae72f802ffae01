"""Our filter, started by a launch file for nav2, between stand-ins over DDS.

``python stand_ins.py SCENARIO LAUNCH PARAMS`` substitutes arguments, starts wmr_filter with its
parameters and remappings, simulates lifecycle manager, collision monitor and base, and prints the
base's commands as JSON.
"""

import sys
import xml.etree.ElementTree as ElementTree

import rclpy
from outside import PATIENCE, SOON, World, has_changed, launch, tell


def main(scenario, file, params):
    root = ElementTree.parse(file).getroot()
    arguments = {item.get("name"): item.get("default", "") for item in root.iter("arg")}
    arguments |= {"scenario": scenario, "params": params}
    arguments |= {"cmd_vel": "base_cmd", "odom": "base_odom"}

    def given(node, kind, key, value):
        """Values of a node's tags of a kind, by key, with the launch file's arguments filled in."""
        (item,) = (item for item in root.iter("node") if item.get("name") == node)
        found = {one.get(key): one.get(value) for one in item.iter(kind) if one.get(key)}
        for name, filled in arguments.items():
            found = {k: text.replace(f"$(var {name})", filled) for k, text in found.items()}
        return found

    settings = given("wmr_filter", "param", "name", "value").items()
    own = [f"{key}:={value or chr(39) * 2}" for key, value in settings]
    remaps = [":=".join(pair) for pair in given("wmr_filter", "remap", "from", "to").items()]
    words = [part for item in (*own, SOON) for part in ("-p", item)]
    process = launch("filter", remaps=remaps, more=["--params-file", params, *words])
    rclpy.init(args=["--ros-args", *(part for item in remaps for part in ("-r", item))])
    world = World(process)

    def of_a_footprint(message):
        message.child_frame_id = "base_footprint"

    manager = given("lifecycle_manager_navigation", "param", "name", "value")
    try:
        for transition in (1, 3) if "wmr_filter" in manager["node_names"] else ():
            assert has_changed(world.node, "wmr_filter", transition), transition
        world.go(
            PATIENCE, lambda: sum(v > 0.8 for _, v, _ in world.seen) > 20,
            spoil=of_a_footprint, command=lambda: world.command(5.0, 0.0),
        )  # fmt: skip
    finally:
        process.kill()
    sent = [v for _, v, _ in world.seen]
    tell({"largest": max(sent, default=0.0), "commands": len(sent)})


if __name__ == "__main__":
    main(*sys.argv[1:])

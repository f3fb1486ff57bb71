"""Prints the target's angular velocity: python3 example.py unix:/run/polhode/telemetry"""

import sys

from polhode_bus import Packet, open_bus


def line(packet: Packet) -> str:
    x, y, z = packet.w_T_rad_s
    return f"frame {packet.frame}: {x:.5f} {y:.5f} {z:.5f} rad/s"


with open_bus(sys.argv[1] if len(sys.argv) > 1 else "unix:/run/polhode/telemetry") as bus:
    for packet in bus.packets(timeout_s=2.0):
        if packet.name == "motion" and packet.rate_valid:
            print(line(packet))
    print(f"{bus.missing} packets missing")

"""Reads and commands Polhode's motion output bus; needs nothing but Python 3.10.

    from polhode_bus import open_bus
    with open_bus("unix:/run/polhode/telemetry") as bus:
        for packet in bus.packets(timeout_s=10.0):
            if packet.name == "motion" and packet.rate_valid:
                print(packet.frame, packet.w_T_rad_s)
"""

from .commands import CommandSender, make_command, make_table_activate, make_table_load
from .decode import Packet, crc16, decode, header_of, name_of, numbers_of, words_of
from .signing import next_number, read_key, sign
from .sources import Bus, open_bus

__all__ = ["Bus", "CommandSender", "Packet", "crc16", "decode", "header_of", "make_command", "make_table_activate",
           "make_table_load", "name_of", "next_number", "numbers_of", "open_bus", "read_key", "sign", "words_of"]

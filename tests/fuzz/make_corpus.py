"""Writes the fixed corpus of the command fuzz target: a good command of each code, and ones that are nearly right."""

import pathlib
import struct

from polhode_bus import crc16, make_command, make_table_activate, make_table_load

HERE = pathlib.Path(__file__).resolve().parent

LOAD = {"features.count_max": 500, "features.sigma_px": 0.3, "mask.enabled": True}


def sealed(octets: bytes) -> bytes:
    return octets + struct.pack(">H", crc16(octets))


def good() -> dict[str, bytes]:
    plain = ("noop", "reset_counters", "reset_map", "hold", "resume", "table_discard", "checkpoint")
    commands = {name: make_command(name) for name in plain}
    commands["set_known_length"] = make_command("set_known_length", frame_timestamp_ns=1700000000000000000, length_m=0.6,
                                                first_px=[812.0, 400.5], second_px=[1010.2, 377.9])
    commands["set_range"] = make_command("set_range", frame_timestamp_ns=1700000000000000000, range_m=12.5)
    commands["servicer_attitude"] = make_command("servicer_attitude", timestamp_ns=5, q_IC=[0.5, 0.5, 0.5, 0.5], w_C_rad_s=[0.0, 0.01, 0.0])
    commands["request_cloud"] = make_command("request_cloud", points_max=1000)
    commands["predict_point"] = make_command("predict_point", predicted_timestamp_ns=5, p_T=[0.1, 0.2, 0.3], normal_T=[0.0, 0.0, 1.0], target_frame=1, number=7)
    commands["table_load"] = make_table_load(LOAD)
    commands["table_activate"] = make_table_activate([LOAD])
    return commands


def nearly() -> dict[str, bytes]:
    noop, length = good()["noop"], good()["set_range"]
    infinite = length[:16] + struct.pack(">d", float("inf"))
    return {"empty": b"", "header_only": noop[:8], "wrong_crc": noop[:-1] + b"\x00", "unknown_code": sealed(noop[:7] + b"\xc8"),
            "other_apid": sealed(b"\x19\xa0" + noop[2:-2]), "telemetry": sealed(b"\x09" + noop[1:-2]), "segmented": sealed(noop[:2] + b"\x40" + noop[3:-2]),
            "other_layout": sealed(noop[:6] + b"\x01" + noop[7:-2]), "infinite_range": sealed(infinite), "too_long": noop + b"\x00",
            "longest": make_table_load(LOAD)[:16] + bytes(1386),
            "zeros": bytes(64)}


if __name__ == "__main__":
    (HERE / "corpus").mkdir(exist_ok=True)
    for name, octets in {**good(), **nearly()}.items():
        (HERE / "corpus" / name).write_bytes(octets)

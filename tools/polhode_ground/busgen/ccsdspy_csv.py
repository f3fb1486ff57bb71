"""CSV definitions for ccsdspy: one file a packet, all that follows the primary header, flat."""

from .table import FLAGS_NUMBER_BITS, SIZES, Table
from .xtce import HEADER

KINDS = {"u": "uint", "i": "int", "f": "float", "t": "str"}
PRIMARY_HEADER_BITS = 48  # ccsdspy reads these by itself


def files(table: Table) -> dict[str, str]:
    head, bits_before = [], 0
    for name, bits, _ in HEADER:
        if bits_before >= PRIMARY_HEADER_BITS:
            head.append(f"{name},uint,{bits}")
        bits_before += bits
    written = {}
    for packet in table.packets:
        rows = ["name,data_type,bit_length", *head]
        for field in packet.fields:
            if field.is_flags and packet.flags_number:
                rows += [f"{packet.flags_number},uint,{FLAGS_NUMBER_BITS}", f"{field.name},uint,{8 - FLAGS_NUMBER_BITS}"]
                continue
            bits = 8 * (field.count if field.type == "text" else SIZES[field.type])
            rows += [f"{name},{KINDS[field.type[0]]},{bits}" for name in field.element_names()]
        written[f"config/bus/ccsdspy/{packet.name}.csv"] = "\n".join([*rows, "CRC,uint,16"]) + "\n"
    return written

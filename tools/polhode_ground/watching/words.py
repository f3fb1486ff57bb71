"""What the page says, as HTML: mode, rates, health, warnings, events, commands. All text of packets is escaped."""

import html
import math
import re
from dataclasses import dataclass

from polhode_ground.busgen.table import Layout, Table
from polhode_ground.watching.state import State

STALE_S = 5.0  # as the ground station's page has it
MODE_COLOURS = {"TRACKING": "#2f7d32", "ACQUIRING": "#1f6fb4", "COASTING": "#b36b00", "LOST": "#c02020", "IDLE": "#666666"}
LEVEL_COLOURS = {"WARNING": "#a35f00", "ERROR": "#c02020", "CRITICAL": "#c02020"}
AXIS_COLOURS = ("#d62728", "#2ca02c", "#1f77b4")  # x, y, z
STYLE = (
    "<style>.polhode{font-size:13px;line-height:1.4;padding:0 10px;font-variant-numeric:tabular-nums}.polhode table{border-collapse:collapse;width:100%}"
    ".polhode td{padding:1px 6px 1px 0;vertical-align:top}.polhode td.n{text-align:right;white-space:nowrap}.polhode table.w td{white-space:normal}.polhode .dim{color:#6b6b6b}"
    ".polhode b.mode{color:#fff;padding:2px 9px;border-radius:4px;font-size:15px}.polhode .bad{color:#c02020;font-weight:600}"
    ".polhode code{font-size:12px;background:#f0f0f0;padding:1px 3px;overflow-wrap:anywhere}.polhode p{margin:4px 0}"
    ".polhode summary{cursor:pointer;padding:2px 0}.polhode details>div{padding:0 0 6px 14px}</style>"
)


def block(content: str) -> str:
    return f'{STYLE}<div class="polhode">{content}</div>'


def rows(pairs: list[tuple[str, str]]) -> str:
    """@param pairs  name and value, as HTML."""
    return "<table>" + "".join(f'<tr><td class="dim">{name}</td><td class="n">{value}</td></tr>' for name, value in pairs) + "</table>"


def breaking(name: str) -> str:
    """A long name as HTML that may be broken at its dots and underscores."""
    return re.sub("([._])", r"\1<wbr>", html.escape(name))


def figure(value: float) -> str:
    return f"{value:.3g}" if abs(value) < 1000 or not math.isfinite(value) else f"{value:.0f}"


def unit_of(state: State) -> str:
    motion = state.latest.get("motion")
    return "m" if motion is not None and motion.scale_known else "map units"


def head(state: State, silence_s: float) -> str:
    """Mode, frame, time; in red when nothing comes any more."""
    motion = state.latest.get("motion")
    if motion is None:
        return block(
            '<p><b class="mode" style="background:#666">NO PACKETS YET</b></p>' if not state.packets else "<p>No motion packet yet.</p>"
        )
    stale = f'<p><b class="mode" style="background:#c02020">STALE: no packet for {silence_s:.0f} s</b></p>' if silence_s > STALE_S else ""
    badge = f'<b class="mode" style="background:{MODE_COLOURS.get(motion.mode, "#666666")}">{html.escape(str(motion.mode))}</b>'
    return block(
        f'{stale}<p>{badge} &nbsp;frame <span id="polhode-frame">{motion.frame}</span> &nbsp;'
        f'<span class="dim">{motion.timestamp_ns / 1e9:.3f} s</span></p>'
    )


def image_note(timestamp_ns: int, has_pose: bool) -> str:
    return f'<span class="dim">image of {timestamp_ns / 1e9:.3f} s{"" if has_pose else ", no pose"}</span>'


def motion_rows(state: State) -> str:
    """Rate and position with their sigmas."""
    motion, pairs = state.latest.get("motion"), []
    if motion is None:
        return block("")
    if motion.rate_valid:
        w = [math.degrees(value) for value in motion.w_T_rad_s]
        parts = "&ensp;".join(
            f'<span style="color:{colour}">{axis} {value:+.3f}</span>' for axis, colour, value in zip("xyz", AXIS_COLOURS, w)
        )
        pairs.append(("rate in T, deg/s", parts))
        pairs.append(("its magnitude, deg/s", f"<b>{math.dist(w, (0, 0, 0)):.3f}</b> &plusmn; {math.degrees(motion.sigma_rate_rad_s):.2g}"))
    else:
        pairs.append(("rate", "not known"))
    if motion.pose_valid:
        unit = unit_of(state)
        pairs.append((f"distance, {unit}", f"<b>{math.dist(motion.p_CT, (0, 0, 0)):.3f}</b> &plusmn; {figure(motion.sigma_pos)}"))
        pairs.append(("sigma of the attitude, deg", figure(math.degrees(motion.sigma_att_rad))))
    else:
        pairs.append(("pose", "none"))
    return block(rows(pairs))


@dataclass(frozen=True)
class Warned:
    level: str  # warning, critical
    packet: str
    name: str
    value: str
    help: str


def warned(state: State, table: Table) -> list[Warned]:
    """Fields beyond the limits of the table of packets, the critical ones first."""
    found = []
    for layout in table.packets:
        packet = state.latest.get(layout.name)
        for entry in layout.fields if packet is not None else []:
            value = packet.values.get(entry.name) if entry.alarm else None
            level = _level(entry.alarm, value)
            if level:
                shown = (
                    value
                    if isinstance(value, str)
                    else ", ".join(figure(one) if isinstance(one, float) else str(one) for one in _all(value))
                )
                found.append(Warned(level, layout.name, entry.name, shown, entry.help))
    return sorted(found, key=lambda one: one.level != "critical")


def _all(value) -> list:
    return value if isinstance(value, list) else [value]


def _level(alarm: dict, value) -> str:
    for level in ("critical", "warning"):
        limit = alarm.get(level, {}) if value is not None else {}
        if any(
            one in limit.get("at", ()) or ("above" in limit and not isinstance(one, str) and one > limit["above"]) for one in _all(value)
        ):
            return level
    return ""


def health(state: State, table: Table) -> str:
    """The machine, what each frame gave, what the watch itself has missed, and warnings."""
    platform, motion, pairs = state.latest.get("platform"), state.latest.get("motion"), []
    if platform is not None:
        pairs += [
            ("step, longest, ms", f"{platform.last_step_us / 1000:.1f}, {platform.longest_step_us / 1000:.1f}"),
            ("frames dropped", str(platform.frames_dropped)),
            ("late steps", str(platform.deadline_misses)),
            ("memory, peak, MB", f"{platform.resident_octets / 1e6:.1f}, {platform.resident_peak_octets / 1e6:.1f}"),
            ("up for, s", str(platform.uptime_s)),
            ("packets sent, dropped", f"{platform.packets_sent}, {platform.packets_dropped}"),
        ]
    if motion is not None:
        pairs += [
            ("features, matched, inliers", f"{motion.features}, {motion.matches}, {motion.inliers}"),
            ("landmarks, keyframes", f"{motion.landmarks}, {motion.keyframes}"),
        ]
    lost = f"{state.missing}, {state.damaged_octets}"
    pairs.append(("packets missed, octets damaged", f'<span class="bad">{lost}</span>' if state.missing or state.damaged_octets else lost))
    found = warned(state, table)
    said = "".join(
        f'<tr title="{html.escape(one.help)}"><td style="color:{"#c02020" if one.level == "critical" else "#a35f00"}">{breaking(f"{one.packet}.{one.name}")}</td>'
        f'<td class="n">{breaking(one.value)}</td></tr>'
        for one in found
    )
    return block(
        rows(pairs)
        + f"<p><b>Warnings</b> {'' if found else '<span class=dim>none</span>'}</p>"
        + (f"<table class=w>{said}</table>" if found else "")
    )


def events(state: State) -> str:
    """The newest first, with the time of their frame."""
    lines = "".join(
        f'<tr><td class="dim" style="white-space:nowrap">{one.timestamp_ns / 1e9:.3f}</td><td style="color:{LEVEL_COLOURS.get(one.severity, "inherit")}">{html.escape(one.text)}</td></tr>'
        for one in state.events
    )
    return block(f"<table>{lines}</table>" if lines else '<p class="dim">none yet</p>')


def commands(table: Table, apid_first: int) -> str:
    """How to send each command; the page sends none."""
    option = f" --apid-first {apid_first}" if apid_first != table.apid_first else ""
    listed = "".join(_command(layout, option) for layout in table.commands)
    return block(
        "<p>This page only reads. Commands go from a shell to an address of the run's <code>transport.receive</code>; append "
        "<code>--key FILE</code> where they are signed, <code>--wait TELEMETRY</code> for the answer.</p>"
        f"{listed}<p class=dim>Documentation: <code>docs/bus.md</code>, Commanding it; <code>docs/security.md</code>, who may command.</p>"
    )


def _command(layout: Layout, option: str) -> str:
    if layout.entry is not None:  # parameters by their names: the program packs them
        words, told = ["PARAMETER=VALUE"], ["a parameter of config/default.toml"]
    else:
        given = [entry for entry in layout.fields if entry.name != "spare"]
        words = [f"{entry.name}={','.join(element.upper() for element in entry.elements) or 'VALUE'}" for entry in given]
        told = [
            f"{entry.name}: {entry.help}{f' [{entry.unit}]' if entry.unit else ''}{f', {entry.range[0]:g} .. {entry.range[1]:g}' if entry.range else ''}"
            for entry in given
        ]
    line = " ".join([f"polhode bus send{option} ADDRESS {layout.name}", *words])
    return (
        f"<details><summary><b>{html.escape(layout.name)}</b></summary><div><code>{html.escape(line)}</code><br>{html.escape(layout.help)}"
        f"{''.join(f'<br>{html.escape(one)}' for one in told)}</div></details>"
    )

#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The Polhode authors
# SPDX-License-Identifier: Apache-2.0
"""The component called from Python by ctypes: frames of a sequence in, packets out.

usage: polhode_ctypes.py libpolhode.so SEQ OUT.ccsds
"""
import csv
import ctypes as c
import pathlib
import sys

import numpy
import PIL.Image
import yaml


class Camera(c.Structure):
    _fields_ = [(n, c.c_int32) for n in ("width_px", "height_px")] + [(n, c.c_double) for n in ("fu", "fv", "cu", "cv", "k1", "k2", "p1", "p2")]


class Octets(c.Structure):
    _fields_ = [("data", c.POINTER(c.c_uint8)), ("length", c.c_size_t)]


class Input(c.Structure):
    _fields_ = [("timestamp_ns", c.c_int64), ("pixels", c.c_void_p), ("width_px", c.c_int32), ("height_px", c.c_int32),
                ("pixel_bits", c.c_int32), ("memory_short", c.c_int32), ("stride_octets", c.c_int64), ("q_IC", c.c_void_p),
                ("finished", c.POINTER(c.c_void_p)), ("finished_count", c.c_size_t), ("commands", c.POINTER(Octets)), ("command_count", c.c_size_t)]


class Motion(c.Structure):
    _fields_ = [("timestamp_ns", c.c_int64), ("frame", c.c_uint32), ("target_frame", c.c_uint32)] + \
        [(n, c.c_uint8) for n in ("mode", "pose_valid", "rate_valid", "velocity_valid", "scale_known", "scale_number")] + [("spare", c.c_uint8 * 2)] + \
        [(n, c.c_uint16) for n in ("features", "matches", "inliers", "landmarks", "keyframes", "spare_count")] + \
        [("q_CT", c.c_double * 4), ("p_CT", c.c_double * 3), ("v_C", c.c_double * 3), ("w_T_rad_s", c.c_double * 3)] + \
        [(n, c.c_double) for n in ("sigma_att_rad", "sigma_pos", "sigma_vel", "sigma_rate_rad_s")]


class Output(c.Structure):
    _fields_ = [("motion", Motion), ("packets", Octets), ("jobs", c.c_void_p * 3), ("job_count", c.c_uint32), ("frame_used", c.c_uint8),
                ("checkpoint_asked", c.c_uint8), ("spare", c.c_uint8 * 2)]


def load(path) -> c.CDLL:
    library = c.CDLL(str(path))
    assert library.polhode_abi() == 1
    for name in ("polhode_parameters_octets", "polhode_memory_needed", "polhode_checkpoint_octets_max"):
        getattr(library, name).restype = c.c_size_t
    library.polhode_version.restype = c.c_char_p
    library.polhode_set_real.argtypes = [c.c_void_p, c.c_char_p, c.c_size_t, c.c_double, c.c_char_p, c.c_size_t]
    library.polhode_set_whole.argtypes = [c.c_void_p, c.c_char_p, c.c_size_t, c.c_int64, c.c_char_p, c.c_size_t]
    return library


class Component:
    """Memory for the parameters and the tables, and what lives in it."""

    def __init__(self, library, camera: Camera, **settings: float):
        self.library, self.handle, self.parameters, self.out = library, c.c_void_p(), c.c_void_p(), []
        self.table = c.create_string_buffer(library.polhode_parameters_octets())
        library.polhode_parameters_create(self.table, c.c_size_t(len(self.table)), c.byref(self.parameters))
        library.polhode_set_camera(self.parameters, c.byref(camera))
        problem = c.create_string_buffer(256)
        for key, value in settings.items():
            if library.polhode_set_real(self.parameters, key.encode(), 0, value, problem, 256):
                raise ValueError(problem.value.decode())
        octets = library.polhode_memory_needed(self.parameters)
        self.memory = c.create_string_buffer(octets + 64)
        aligned = (c.addressof(self.memory) + 63) // 64 * 64
        if library.polhode_create(c.c_void_p(aligned), c.c_size_t(octets), self.parameters, c.byref(self.handle), problem, c.c_size_t(256)):
            raise ValueError(problem.value.decode())

    def step(self, timestamp_ns: int, picture: numpy.ndarray | None, **more) -> Output:
        due, step = [], self.library.polhode_next_step(self.handle)
        while self.out and self.library.polhode_due_step(self.out[0]) <= step:
            due.append(self.out.pop(0))
        jobs = (c.c_void_p * 3)(*due)
        frame = Input(**{"timestamp_ns": timestamp_ns, "pixel_bits": 8, "finished": jobs, "finished_count": len(due)} | more)
        output = Output()
        if picture is not None:
            frame.pixels, (frame.height_px, frame.width_px), frame.stride_octets = picture.ctypes.data, picture.shape, picture.strides[0]
        status = self.library.polhode_step(self.handle, c.byref(frame), c.byref(output))
        if status:
            raise RuntimeError(status)
        for job in map(c.c_void_p, output.jobs[:output.job_count]):  # a flight host has a second core for them
            self.library.polhode_run_job(job)
            self.out = sorted([*self.out, job], key=self.library.polhode_due_step)
        return output


def packets_of(output: Output) -> bytes:
    return c.string_at(output.packets.data, output.packets.length)


def camera_of(sequence: pathlib.Path) -> Camera:
    sensor = yaml.safe_load((sequence / "mav0/cam0/sensor.yaml").read_text())
    return Camera(*sensor["resolution"], *sensor["intrinsics"], *sensor["distortion_coefficients"])


def main(library: str, sequence: str, out: str) -> None:
    component = Component(load(library), camera_of(pathlib.Path(sequence)))
    folder = pathlib.Path(sequence) / "mav0/cam0"
    with open(out, "wb") as bus, (folder / "data.csv").open() as table:
        for timestamp_ns, name in list(csv.reader(table))[1:]:
            picture = numpy.ascontiguousarray(PIL.Image.open(folder / "data" / name))
            bus.write(packets_of(component.step(int(timestamp_ns), picture)))


if __name__ == "__main__":
    main(*sys.argv[1:])

/* SPDX-FileCopyrightText: 2026 The Polhode authors
 * SPDX-License-Identifier: Apache-2.0
 *
 * A sequence of gray 8-bit PNG files in the ASL layout: what stands for the camera in main.c. */
#ifndef POLHODE_EXAMPLE_SEQUENCE_H
#define POLHODE_EXAMPLE_SEQUENCE_H

#include <stdint.h>
#include <stdio.h>

#include "polhode.h"

typedef struct sequence {
  char folder[512];
  FILE* table; /* data.csv, at its next row */
  polhode_camera camera;
  uint8_t* pixels; /* of the last frame read; owned */
} sequence;

/* 0, or 1 after a line on stderr that says what is wrong. */
int sequence_open(const char* folder, sequence* out);
void sequence_close(sequence* open);

/* 1: a frame, in `pixels`, or null where it cannot be read; 0: no more frames. */
int sequence_next(sequence* open, int64_t* timestamp_ns, const uint8_t** pixels);

#endif

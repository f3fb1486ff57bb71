/* SPDX-FileCopyrightText: 2026 The Polhode authors
 * SPDX-License-Identifier: Apache-2.0
 *
 * The target's flat faces, read from the packets of a step. */
#ifndef POLHODE_EXAMPLE_FACES_H
#define POLHODE_EXAMPLE_FACES_H

#include <stddef.h>
#include <stdint.h>

enum { FACES_MAX = 12 };

/* In T and the unit of published lengths. */
typedef struct faces {
  int count;
  double centre_T[FACES_MAX][3];
  double normal_T[FACES_MAX][3];
  double area[FACES_MAX]; /* of the rectangle about its points */
} faces;

/* Of the last shape packet among these; without one `out` stays as it is. */
void faces_update(const uint8_t* packets, size_t octets, faces* out);

#endif

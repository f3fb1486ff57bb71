/* SPDX-FileCopyrightText: 2026 The Polhode authors
 * SPDX-License-Identifier: Apache-2.0 */
#include "faces.h"

#include "polhode_bus.h"

enum { HEADER_OCTETS = 6, LENGTH_AT = 4 };

static void take(const struct polhode_shape* shape, faces* out) {
  out->count = (shape->flags & POLHODE_SHAPE_SHAPE) != 0 ? shape->plane_count : 0;
  for (int i = 0; i < out->count; ++i) {
    for (int k = 0; k < 3; ++k) {
      out->centre_T[i][k] = shape->plane_centre_T[3 * i + k];
      out->normal_T[i][k] = shape->plane_normal_T[3 * i + k];
    }
    out->area[i] = (double)shape->plane_extent[2 * i] * shape->plane_extent[2 * i + 1];
  }
}

void faces_update(const uint8_t* packets, size_t octets, faces* out) {
  size_t at = 0;
  while (at + HEADER_OCTETS <= octets) {
    /* CCSDS 133.0-B: octets after the primary header, less one. */
    const size_t length = HEADER_OCTETS + 1 + ((size_t)packets[at + LENGTH_AT] << 8 | packets[at + LENGTH_AT + 1]);
    struct polhode_shape shape;
    if (at + length <= octets && polhode_decode(packets + at, length, POLHODE_SHAPE, &shape, sizeof shape) == 0) {
      take(&shape, out);
    }
    at += length;
  }
}

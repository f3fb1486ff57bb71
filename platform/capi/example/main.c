/* SPDX-FileCopyrightText: 2026 The Polhode authors
 * SPDX-License-Identifier: Apache-2.0
 *
 * The loop of a C host: a frame, a step, its packets, its jobs.
 *   polhode_c_example SEQ OUT.ccsds [key=value]... */
#include <stdio.h>

#include "host.h"

static int fly(host* h, sequence* camera, FILE* bus) {
  polhode_output output;
  int more = 0;
  while ((more = host_step(h, camera, &output)) > 0) {
    if (fwrite(output.packets.data, 1, output.packets.length, bus) != output.packets.length) {
      fprintf(stderr, "polhode_c_example: the packets cannot be written\n");
      return 1;
    }
  }
  return more == 0 ? 0 : 1;
}

int main(int argc, char** argv) {
  if (argc < 3) {
    fprintf(stderr, "usage: polhode_c_example SEQ OUT.ccsds [key=value]...\n");
    return HOST_UNUSABLE;
  }
  sequence camera;
  int result = HOST_UNUSABLE;
  if (sequence_open(argv[1], &camera) == 0) {
    FILE* bus = fopen(argv[2], "wb");
    if (bus == NULL) {
      fprintf(stderr, "polhode_c_example: %s: cannot be written\n", argv[2]);
    } else {
      host h;
      result = host_open("polhode_c_example", &camera, argc - 3, argv + 3, &h);
      result = result == 0 ? fly(&h, &camera, bus) : result;
      host_close(&h);
      result = fclose(bus) != 0 && result == 0 ? 1 : result;
    }
  }
  sequence_close(&camera);
  return result;
}

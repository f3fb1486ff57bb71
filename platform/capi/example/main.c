/* SPDX-FileCopyrightText: 2026 The Polhode authors
 * SPDX-License-Identifier: Apache-2.0
 *
 * The loop of a C host: a frame, a step, its packets, its jobs.
 *   polhode_c_example SEQ OUT.ccsds [key=value]...
 * Jobs are run between the steps, where a flight host has its background task. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "polhode.h"
#include "sequence.h"

enum { PROBLEM_OCTETS = 256, UNUSABLE = 2 };

static int refuse(const char* what, polhode_status status, const char* problem) {
  fprintf(stderr, "polhode_c_example: %s: %s\n", what, problem[0] != '\0' ? problem : polhode_status_name(status));
  return UNUSABLE;
}

/* key=value from the command line into the table. */
static int set_parameters(polhode_parameters* parameters, int count, char** settings) {
  for (int i = 0; i < count; ++i) {
    char problem[PROBLEM_OCTETS] = "";
    char* value = strchr(settings[i], '=');
    char* end = value;
    if (value != NULL) {
      *value++ = '\0';
      const double number = strtod(value, &end);
      const polhode_status status = polhode_set_real(parameters, settings[i], 0, number, problem, sizeof problem);
      if (status != POLHODE_OK) {
        return refuse("parameter", status, problem);
      }
    }
    if (value == NULL || end == value || *end != '\0') {
      return refuse(settings[i], POLHODE_BAD_ARGUMENT, "a key, = and a number are needed");
    }
  }
  return 0;
}

/* The jobs that are due at the next step, out of those that are out. */
static size_t take_due(polhode_job** out, size_t* count, uint32_t step, polhode_job** due) {
  size_t taken = 0;
  size_t kept = 0;
  for (size_t i = 0; i < *count; ++i) {
    if (polhode_due_step(out[i]) <= step) {
      due[taken++] = out[i];
    } else {
      out[kept++] = out[i];
    }
  }
  *count = kept;
  return taken;
}

static int fly(polhode_component* component, sequence* camera, FILE* bus) {
  polhode_job* out[POLHODE_JOBS_MAX];
  polhode_job* due[POLHODE_JOBS_MAX];
  size_t out_count = 0;
  polhode_input input = {.width_px = camera->camera.width_px,
                         .height_px = camera->camera.height_px,
                         .pixel_bits = 8,
                         .stride_octets = camera->camera.width_px,
                         .finished = due};
  while (sequence_next(camera, &input.timestamp_ns, &input.pixels)) {
    input.finished_count = take_due(out, &out_count, polhode_next_step(component), due);
    polhode_output output;
    const polhode_status status = polhode_step(component, &input, &output);
    if (status != POLHODE_OK) {
      fprintf(stderr, "polhode_c_example: step: %s\n", polhode_status_name(status));
      return 1;
    }
    if (fwrite(output.packets.data, 1, output.packets.length, bus) != output.packets.length) {
      fprintf(stderr, "polhode_c_example: the packets cannot be written\n");
      return 1;
    }
    for (uint32_t i = 0; i < output.job_count; ++i) {
      if (polhode_run_job(output.jobs[i]) != POLHODE_OK) {
        polhode_skip_job(output.jobs[i]);
      }
      out[out_count++] = output.jobs[i];
    }
  }
  return 0;
}

static int run(sequence* camera, FILE* bus, int count, char** settings) {
  char problem[PROBLEM_OCTETS] = "";
  polhode_parameters* parameters = NULL;
  void* table = malloc(polhode_parameters_octets());
  polhode_status status = polhode_parameters_create(table, polhode_parameters_octets(), &parameters);
  if (status != POLHODE_OK) {
    return refuse("parameters", status, problem);
  }
  int result = set_parameters(parameters, count, settings);
  if (result == 0) {
    (void)polhode_set_camera(parameters, &camera->camera);
    const size_t needed = polhode_memory_needed(parameters);
    const size_t octets = (needed + POLHODE_MEMORY_ALIGNMENT - 1) / POLHODE_MEMORY_ALIGNMENT * POLHODE_MEMORY_ALIGNMENT;
    void* memory = aligned_alloc(POLHODE_MEMORY_ALIGNMENT, octets);
    polhode_component* component = NULL;
    status = polhode_create(memory, octets, parameters, &component, problem, sizeof problem);
    result = status == POLHODE_OK ? fly(component, camera, bus) : refuse("component", status, problem);
    polhode_destroy(component);
    free(memory);
  }
  free(table);
  return result;
}

int main(int argc, char** argv) {
  if (argc < 3) {
    fprintf(stderr, "usage: polhode_c_example SEQ OUT.ccsds [key=value]...\n");
    return UNUSABLE;
  }
  sequence camera;
  int result = UNUSABLE;
  if (sequence_open(argv[1], &camera) == 0) {
    FILE* bus = fopen(argv[2], "wb");
    if (bus == NULL) {
      fprintf(stderr, "polhode_c_example: %s: cannot be written\n", argv[2]);
    } else {
      result = run(&camera, bus, argc - 3, argv + 3);
      result = fclose(bus) != 0 && result == 0 ? 1 : result;
    }
  }
  sequence_close(&camera);
  return result;
}

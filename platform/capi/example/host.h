/* SPDX-FileCopyrightText: 2026 The Polhode authors
 * SPDX-License-Identifier: Apache-2.0
 *
 * What both examples share of a C host: parameters, memory, a step with its jobs. In the header, so that an example is one
 * file beside sequence.c. */
#ifndef POLHODE_EXAMPLE_HOST_H
#define POLHODE_EXAMPLE_HOST_H

#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "polhode.h"
#include "sequence.h"

enum { HOST_PROBLEM_OCTETS = 256, HOST_UNUSABLE = 2 };

typedef struct host {
  const char* name; /* of the program, before what it says on stderr */
  polhode_component* component;
  void* table;  /* the parameters' memory */
  void* memory; /* the component's */
  polhode_job* out[POLHODE_JOBS_MAX];
  size_t out_count;
} host;

/* A line on stderr: what, and the problem or else the status in words. @return HOST_UNUSABLE */
static int host_refuse(const host* h, const char* what, polhode_status status, const char* problem) {
  fprintf(stderr, "%s: %s: %s\n", h->name, what, problem[0] != '\0' ? problem : polhode_status_name(status));
  return HOST_UNUSABLE;
}

/* key=value from the command line into the table. */
static int set_parameters(const host* h, polhode_parameters* parameters, int count, char** settings) {
  for (int i = 0; i < count; ++i) {
    char problem[HOST_PROBLEM_OCTETS] = "";
    char* value = strchr(settings[i], '=');
    char* end = value;
    if (value != NULL) {
      *value++ = '\0';
      const double number = strtod(value, &end);
      const polhode_status status = polhode_set_real(parameters, settings[i], 0, number, problem, sizeof problem);
      if (status != POLHODE_OK) {
        return host_refuse(h, "parameter", status, problem);
      }
    }
    if (value == NULL || end == value || *end != '\0') {
      return host_refuse(h, settings[i], POLHODE_BAD_ARGUMENT, "a key, = and a number are needed");
    }
  }
  return 0;
}

/* A component for the sequence's camera, with settings key=value. 0, or HOST_UNUSABLE after a line on stderr. `h` is to be closed in
 * either case. */
static int host_open(const char* name, const sequence* camera, int count, char** settings, host* h) {
  *h = (host){.name = name};
  char problem[HOST_PROBLEM_OCTETS] = "";
  polhode_parameters* parameters = NULL;
  h->table = malloc(polhode_parameters_octets());
  polhode_status status = polhode_parameters_create(h->table, polhode_parameters_octets(), &parameters);
  if (status != POLHODE_OK) {
    return host_refuse(h, "parameters", status, problem);
  }
  if (set_parameters(h, parameters, count, settings) != 0) {
    return HOST_UNUSABLE;
  }
  (void)polhode_set_camera(parameters, &camera->camera);
  const size_t needed = polhode_memory_needed(parameters);
  const size_t octets = (needed + POLHODE_MEMORY_ALIGNMENT - 1) / POLHODE_MEMORY_ALIGNMENT * POLHODE_MEMORY_ALIGNMENT;
  h->memory = aligned_alloc(POLHODE_MEMORY_ALIGNMENT, octets);
  status = polhode_create(h->memory, octets, parameters, &h->component, problem, sizeof problem);
  return status == POLHODE_OK ? 0 : host_refuse(h, "component", status, problem);
}

static void host_close(host* h) {
  polhode_destroy(h->component);
  free(h->memory);
  free(h->table);
}

/* The jobs that are due at the next step, out of those that are out. */
static size_t take_due(host* h, polhode_job** due) {
  const uint32_t step = polhode_next_step(h->component);
  size_t taken = 0;
  size_t kept = 0;
  for (size_t i = 0; i < h->out_count; ++i) {
    if (polhode_due_step(h->out[i]) <= step) {
      due[taken++] = h->out[i];
    } else {
      h->out[kept++] = h->out[i];
    }
  }
  h->out_count = kept;
  return taken;
}

/* The next frame of the sequence, its step, and then its jobs, where a flight host has its background task. 1: done; 0: no more
 * frames; -1: a step failed, after a line on stderr. */
static int host_step(host* h, sequence* camera, polhode_output* output) {
  polhode_job* due[POLHODE_JOBS_MAX];
  polhode_input input = {.width_px = camera->camera.width_px,
                         .height_px = camera->camera.height_px,
                         .pixel_bits = 8,
                         .stride_octets = camera->camera.width_px,
                         .finished = due};
  if (!sequence_next(camera, &input.timestamp_ns, &input.pixels)) {
    return 0;
  }
  input.finished_count = take_due(h, due);
  const polhode_status status = polhode_step(h->component, &input, output);
  if (status != POLHODE_OK) {
    (void)host_refuse(h, "step", status, "");
    return -1;
  }
  for (uint32_t i = 0; i < output->job_count; ++i) {
    if (polhode_run_job(output->jobs[i]) != POLHODE_OK) {
      polhode_skip_job(output->jobs[i]);
    }
    h->out[h->out_count++] = output->jobs[i];
  }
  return 1;
}

#endif

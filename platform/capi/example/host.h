/* SPDX-FileCopyrightText: 2026 The Polhode authors
 * SPDX-License-Identifier: Apache-2.0
 *
 * What both examples share of a C host: parameters, memory, a step with its jobs. */
#ifndef POLHODE_EXAMPLE_HOST_H
#define POLHODE_EXAMPLE_HOST_H

#include <stddef.h>

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
int host_refuse(const host* h, const char* what, polhode_status status, const char* problem);

/* A component for the sequence's camera, with settings key=value. 0, or HOST_UNUSABLE after a line on stderr. `h` is to be closed in
 * either case. */
int host_open(const char* name, const sequence* camera, int count, char** settings, host* h);
void host_close(host* h);

/* The next frame of the sequence, its step, and then its jobs, where a flight host has its background task. 1: done; 0: no more
 * frames; -1: a step failed, after a line on stderr. */
int host_step(host* h, sequence* camera, polhode_output* output);

#endif

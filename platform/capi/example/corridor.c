/* SPDX-FileCopyrightText: 2026 The Polhode authors
 * SPDX-License-Identifier: Apache-2.0
 *
 * The corridor along which a servicer may approach a face of the target, second by second after the last frame.
 *   polhode_corridor_example SEQ OUT.csv FACE AHEAD_S [key=value]...
 * FACE is a face's number in the last shape packet, from 0; "largest" takes the one of the greatest area. A corridor is a cone about
 * the face's normal, its apex on the face. What three sigma of the normal take of its half-angle is not safe to fly in. It is open
 * while the servicer, at C's origin, looks at the face from within FACING_DEG of its normal. tools/report.py draws OUT.csv where it
 * lies in a run's folder as corridor.csv. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "faces.h"
#include "host.h"

#define DEG_PER_RAD 57.29577951308232
#define HALF_ANGLE_DEG 15.0 /* of a corridor whose face is known exactly: the plume of an approach stays inside */
#define FACING_DEG 60.0     /* beyond it a face is seen too obliquely to be aligned with */
#define SIGMAS 3.0

static double dot(const double* a, const double* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* 1-sigma of the position along the direction in which it is known worst is at most the root of the trace. */
static double sigma_of(const double* covariance) { return sqrt(covariance[0] + covariance[3] + covariance[5]); }

/* @return 1 where the corridor is open */
static int write_row(const polhode_point* point, FILE* out) {
  const double range = sqrt(dot(point->p_C, point->p_C));
  const double facing_deg = DEG_PER_RAD * acos(fmax(-1.0, fmin(1.0, -dot(point->p_C, point->normal_C) / range)));
  const double half_angle_deg = fmax(0.0, HALF_ANGLE_DEG - SIGMAS * DEG_PER_RAD * point->sigma_normal_rad);
  const int known = point->position_valid && point->normal_valid;
  const int is_open = known && half_angle_deg > 0.0 && facing_deg < FACING_DEG;
  fprintf(out, "%lld,%.3f,%d,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.6g,%.6g,%.4f,%.4f,%d\n", (long long)point->timestamp_ns,
          1e-9 * (double)(point->timestamp_ns - point->from_timestamp_ns), known, point->p_C[0], point->p_C[1], point->p_C[2], point->normal_C[0],
          point->normal_C[1], point->normal_C[2], sigma_of(point->cov_p), DEG_PER_RAD * point->sigma_normal_rad, known ? facing_deg : 0.0,
          known ? half_angle_deg : 0.0, is_open);
  return is_open;
}

/* Seconds for which there was an answer, or -1 after a line on stderr. */
static long write_corridor(host* h, polhode_point_question asked, double ahead_s, FILE* out) {
  const int64_t from_ns = asked.timestamp_ns;
  long answered = 0;
  long open_for = 0;
  fprintf(out, "#timestamp [ns],ahead_s,known,p_C_x,p_C_y,p_C_z,normal_C_x,normal_C_y,normal_C_z,sigma_p,sigma_normal_deg,facing_deg,half_angle_deg,open\n");
  for (long second = 0; (double)second <= ahead_s; ++second) {
    char problem[HOST_PROBLEM_OCTETS] = "";
    polhode_point point;
    asked.timestamp_ns = from_ns + second * 1000000000LL;
    const polhode_status status = polhode_predict_point(h->component, &asked, &point, problem, sizeof problem);
    if (status == POLHODE_NOT_KNOWN) {
      fprintf(stderr, "%s: %ld s ahead: %s\n", h->name, second, problem);
      break;
    }
    if (status != POLHODE_OK) {
      (void)host_refuse(h, "point", status, problem);
      return -1;
    }
    open_for += write_row(&point, out);
    ++answered;
  }
  printf("open in %ld of %ld s\n", open_for, answered);
  return answered;
}

/* The number of the face that is meant, or -1 after a line on stderr. */
static int find_face(const host* h, const faces* known, const char* word) {
  char* end = NULL;
  long number = strtol(word, &end, 10);
  if (strcmp(word, "largest") == 0) {
    number = 0;
    for (int i = 1; i < known->count; ++i) {
      number = known->area[i] > known->area[number] ? i : number;
    }
  } else if (end == word || *end != '\0') {
    number = -1;
  }
  if (number < 0 || number >= known->count) {
    fprintf(stderr, "%s: face %s: the last shape packet has %d, numbered from 0\n", h->name, word, known->count);
    return -1;
  }
  return (int)number;
}

static int plan(host* h, sequence* camera, const char* face, double ahead_s, FILE* out) {
  polhode_output output = {0};
  polhode_point_question asked = {0};
  faces known = {0};
  int more = 0;
  while ((more = host_step(h, camera, &output)) > 0) {
    asked.timestamp_ns = output.motion.timestamp_ns;
    asked.target_frame = output.motion.target_frame;
    faces_update(output.packets.data, output.packets.length, &known);
  }
  const int number = more < 0 ? -1 : find_face(h, &known, face);
  if (number < 0) {
    return 1;
  }
  memcpy(asked.p_T, known.centre_T[number], sizeof asked.p_T);
  memcpy(asked.normal_T, known.normal_T[number], sizeof asked.normal_T);
  printf("face %d of %d: centre_T %.9g %.9g %.9g, normal_T %.9g %.9g %.9g, frame T %u\n", number, known.count, asked.p_T[0], asked.p_T[1], asked.p_T[2],
         asked.normal_T[0], asked.normal_T[1], asked.normal_T[2], asked.target_frame);
  const long answered = write_corridor(h, asked, ahead_s, out);
  if (answered == 0) {
    fprintf(stderr, "%s: nothing is known of the target's motion at the last frame\n", h->name);
  }
  return answered > 0 ? 0 : 1;
}

int main(int argc, char** argv) {
  char* end = NULL;
  const double ahead_s = argc > 4 ? strtod(argv[4], &end) : 0.0;
  if (argc < 5 || end == argv[4] || *end != '\0' || !(ahead_s >= 0.0 && ahead_s <= 600.0)) {
    fprintf(stderr, "usage: polhode_corridor_example SEQ OUT.csv FACE AHEAD_S [key=value]...   AHEAD_S: 0 .. 600\n");
    return HOST_UNUSABLE;
  }
  sequence camera;
  int result = HOST_UNUSABLE;
  if (sequence_open(argv[1], &camera) == 0) {
    FILE* out = fopen(argv[2], "w");
    if (out == NULL) {
      fprintf(stderr, "polhode_corridor_example: %s: cannot be written\n", argv[2]);
    } else {
      host h;
      result = host_open("polhode_corridor_example", &camera, argc - 5, argv + 5, &h);
      result = result == 0 ? plan(&h, &camera, argv[3], ahead_s, out) : result;
      host_close(&h);
      result = fclose(out) != 0 && result == 0 ? 1 : result;
    }
  }
  sequence_close(&camera);
  return result;
}

/* SPDX-FileCopyrightText: 2026 The Polhode authors
 * SPDX-License-Identifier: Apache-2.0 */
#include "sequence.h"

#include <inttypes.h>
#include <png.h>
#include <stdlib.h>
#include <string.h>

enum { PATH_OCTETS = 2048, LINE_OCTETS = 512, CAMERA_LINES = 3 };

/* The three lines of sensor.yaml that say what the camera is, as this project writes them. */
static int read_camera(FILE* file, polhode_camera* c) {
  char line[LINE_OCTETS];
  int found = 0;
  while (fgets(line, sizeof line, file) != NULL) {
    found += sscanf(line, "resolution: [%" SCNd32 ", %" SCNd32 "]", &c->width_px, &c->height_px) == 2;
    found += sscanf(line, "intrinsics: [%lf, %lf, %lf, %lf]", &c->fu_px, &c->fv_px, &c->cu_px, &c->cv_px) == 4;
    found += sscanf(line, "distortion_coefficients: [%lf, %lf, %lf, %lf]", &c->k1, &c->k2, &c->p1, &c->p2) == 4;
  }
  return found == CAMERA_LINES;
}

static FILE* open_file(const char* folder, const char* name) {
  char path[PATH_OCTETS];
  (void)snprintf(path, sizeof path, "%s/mav0/cam0/%s", folder, name);
  FILE* file = fopen(path, "r");
  if (file == NULL) {
    fprintf(stderr, "polhode_c_example: %s: cannot be opened\n", path);
  }
  return file;
}

int sequence_open(const char* folder, sequence* out) {
  memset(out, 0, sizeof *out);
  (void)snprintf(out->folder, sizeof out->folder, "%s", folder);
  FILE* sensor = open_file(folder, "sensor.yaml");
  if (sensor == NULL) {
    return 1;
  }
  const int good = read_camera(sensor, &out->camera) && out->camera.width_px > 0 && out->camera.height_px > 0;
  fclose(sensor);
  if (!good) {
    fprintf(stderr, "polhode_c_example: %s: sensor.yaml lacks resolution, intrinsics or distortion_coefficients\n", folder);
    return 1;
  }
  out->table = open_file(folder, "data.csv");
  out->pixels = malloc((size_t)out->camera.width_px * (size_t)out->camera.height_px);
  return out->table == NULL || out->pixels == NULL;
}

void sequence_close(sequence* open) {
  if (open->table != NULL) {
    fclose(open->table);
  }
  free(open->pixels);
}

/* As it is: gray values are not converted. */
static int read_png(const sequence* s, const char* name) {
  char path[PATH_OCTETS];
  (void)snprintf(path, sizeof path, "%s/mav0/cam0/data/%s", s->folder, name);
  png_image image = {.version = PNG_IMAGE_VERSION};
  if (!png_image_begin_read_from_file(&image, path)) {
    return 0;
  }
  const int fits = image.format == PNG_FORMAT_GRAY && image.width == (png_uint_32)s->camera.width_px &&
                   image.height == (png_uint_32)s->camera.height_px;
  const int read = fits && png_image_finish_read(&image, NULL, s->pixels, 0, NULL);
  png_image_free(&image);
  return read;
}

int sequence_next(sequence* open, int64_t* timestamp_ns, const uint8_t** pixels) {
  char line[LINE_OCTETS];
  char name[LINE_OCTETS];
  while (fgets(line, sizeof line, open->table) != NULL) {
    if (sscanf(line, "%" SCNd64 ",%511[^\r\n]", timestamp_ns, name) == 2) {
      *pixels = read_png(open, name) ? open->pixels : NULL;
      return 1;
    }
  }
  return 0;
}

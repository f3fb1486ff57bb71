/* How the fields of a packet lie on the wire and in its struct. Internal to the client library. */
#ifndef POLHODE_FIELDS_H
#define POLHODE_FIELDS_H

#include <stddef.h>
#include <stdint.h>

enum polhode_type {
  POLHODE_TYPE_U8,
  POLHODE_TYPE_U16,
  POLHODE_TYPE_U32,
  POLHODE_TYPE_U64,
  POLHODE_TYPE_I64,
  POLHODE_TYPE_F32,
  POLHODE_TYPE_F64,
  POLHODE_TYPE_TEXT
};

struct polhode_field {
  size_t member;  /* offset in the struct */
  uint16_t octet; /* from the packet's first */
  uint16_t count; /* values; octets of a text */
  enum polhode_type type;
};

struct polhode_layout {
  int number;
  size_t octets;
  size_t struct_octets;
  const struct polhode_field *fields;
  size_t field_count;
};

extern const struct polhode_layout polhode_layouts[];
extern const size_t polhode_layout_count;

#endif

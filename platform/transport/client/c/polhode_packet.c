/* Packets: checks and decoding. */
#include <string.h>

#include "polhode_bus.h"
#include "polhode_fields.h"

#define HEADER_OCTETS 16

static uint64_t get(const uint8_t *in, size_t octets) {
  uint64_t value = 0;
  for (size_t i = 0; i < octets; ++i) {
    value = value << 8 | in[i];
  }
  return value;
}

/* What the four highest bits of the remainder do to the rest. */
static const uint16_t crc_of_nibble[16] = {0x0000, 0x1021, 0x2042, 0x3063, 0x4084, 0x50A5, 0x60C6, 0x70E7,
                                      0x8108, 0x9129, 0xA14A, 0xB16B, 0xC18C, 0xD1AD, 0xE1CE, 0xF1EF};

uint16_t polhode_crc16(const uint8_t *octets, size_t count) {
  unsigned crc = 0xFFFF;
  for (size_t i = 0; i < count; ++i) {
    crc ^= (unsigned)octets[i] << 8;
    crc = (crc << 4 ^ crc_of_nibble[crc >> 12]) & 0xFFFF;
    crc = (crc << 4 ^ crc_of_nibble[crc >> 12]) & 0xFFFF;
  }
  return (uint16_t)crc;
}

int polhode_kind(const uint8_t *packet, size_t octets) {
  if (octets < HEADER_OCTETS) {
    return -1;
  }
  const int number = (int)(get(packet, 2) & 0x7FF) - POLHODE_APID_FIRST;
  for (size_t i = 0; i < polhode_layout_count; ++i) {
    if (polhode_layouts[i].number == number) {
      return number;
    }
  }
  return -1;
}

static size_t size_of(enum polhode_type type) {
  switch (type) {
    case POLHODE_TYPE_U8:
    case POLHODE_TYPE_TEXT:
      return 1;
    case POLHODE_TYPE_U16:
      return 2;
    case POLHODE_TYPE_U32:
    case POLHODE_TYPE_F32:
      return 4;
    default:
      return 8;
  }
}

static void set_value(uint8_t *to, uint64_t bits, size_t octets) {
  const uint8_t u8 = (uint8_t)bits;
  const uint16_t u16 = (uint16_t)bits;
  const uint32_t u32 = (uint32_t)bits;
  const void *from = octets == 1 ? (const void *)&u8 : octets == 2 ? (const void *)&u16 : octets == 4 ? (const void *)&u32 : &bits;
  memcpy(to, from, octets);
}

static void unpack(const struct polhode_layout *layout, const uint8_t *packet, uint8_t *out) {
  memset(out, 0, layout->struct_octets);
  for (size_t f = 0; f < layout->field_count; ++f) {
    const struct polhode_field *field = &layout->fields[f];
    const size_t size = size_of(field->type);
    for (size_t i = 0; i < field->count; ++i) {
      set_value(out + field->member + i * size, get(packet + field->octet + i * size, size), size);
    }
  }
}

int polhode_decode(const uint8_t *packet, size_t octets, int kind, void *out, size_t struct_octets) {
  if (polhode_kind(packet, octets) != kind) {
    return -1;
  }
  for (size_t i = 0; i < polhode_layout_count; ++i) {
    const struct polhode_layout *layout = &polhode_layouts[i];
    if (layout->number != kind) {
      continue;
    }
    if (octets != layout->octets || struct_octets != layout->struct_octets || get(packet + 4, 2) + 7 != octets ||
        (packet[0] & 0xF8) != 0x08 || packet[14] != POLHODE_LAYOUT_VERSION || polhode_crc16(packet, octets) != 0) {
      return -1;
    }
    unpack(layout, packet, out);
    return 0;
  }
  return -1;
}

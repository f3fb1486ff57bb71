/* The trailer of a signed command, and the file of its key. */
#define _GNU_SOURCE
#include "polhode_sign.h"

#include <errno.h>
#include <fcntl.h>
#include <openssl/evp.h>
#include <openssl/hmac.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

enum { HEADER_OCTETS = 6, DIGITS = 2 * POLHODE_KEY_OCTETS };

static int digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

/* The digits, with at most one end of line behind them. */
static int key_of(const char* text, size_t octets, struct polhode_key* key) {
  if (octets > 0 && text[octets - 1] == '\n') --octets;
  if (octets != DIGITS) return -EINVAL;
  for (size_t i = 0; i < POLHODE_KEY_OCTETS; ++i) {
    const int high = digit(text[2 * i]);
    const int low = digit(text[2 * i + 1]);
    if (high < 0 || low < 0) return -EINVAL;
    key->octets[i] = (uint8_t)(high << 4 | low);
  }
  return 0;
}

int polhode_key_read(struct polhode_key* key, const char* file) {
  char text[DIGITS + 2]; /* an end of line, and one more that tells a longer file */
  struct stat status;
  const int fd =
      open(file, O_RDONLY | O_CLOEXEC | O_NONBLOCK); /* the last is for a pipe in the place */
  if (fd < 0) return -errno;
  int failed = fstat(fd, &status) != 0 ? -errno : 0;
  if (failed == 0 && (!S_ISREG(status.st_mode) || (status.st_mode & 077) != 0 ||
                      (status.st_uid != geteuid() && status.st_uid != 0))) {
    failed = -EPERM;
  }
  if (failed == 0) {
    const ssize_t octets = read(fd, text, sizeof text);
    failed = octets < 0 ? -errno : key_of(text, (size_t)octets, key);
  }
  close(fd);
  explicit_bzero(text, sizeof text);
  return failed;
}

uint64_t polhode_next_number(uint64_t last) {
  struct timespec now;
  clock_gettime(CLOCK_REALTIME, &now);
  const uint64_t now_ns = (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
  return now_ns > last ? now_ns : last + 1;
}

int polhode_mac(const struct polhode_key* key,
                const uint8_t* octets,
                size_t count,
                uint8_t mac[POLHODE_MAC_OCTETS]) {
  uint8_t whole[EVP_MAX_MD_SIZE];
  unsigned size = 0;
  if (HMAC(EVP_sha256(), key->octets, POLHODE_KEY_OCTETS, octets, count, whole, &size) == NULL)
    return -EIO;
  memcpy(mac, whole, POLHODE_MAC_OCTETS);
  return 0;
}

int polhode_sign(const struct polhode_key* key,
                 uint64_t number,
                 uint8_t* packet,
                 size_t octets,
                 size_t capacity) {
  const size_t all = octets + POLHODE_TRAILER_OCTETS;
  if (octets <= HEADER_OCTETS || ((size_t)packet[4] << 8 | packet[5]) + HEADER_OCTETS + 1 != octets)
    return -EINVAL;
  if (all > capacity || all > 0xFFFF) return -EMSGSIZE;
  packet[4] = (uint8_t)((all - HEADER_OCTETS - 1) >> 8);
  packet[5] = (uint8_t)(all - HEADER_OCTETS - 1);
  for (int i = 0; i < POLHODE_NUMBER_OCTETS; ++i) {
    packet[octets + (size_t)i] = (uint8_t)(number >> (56 - 8 * i));
  }
  const int failed =
      polhode_mac(key, packet, all - POLHODE_MAC_OCTETS, packet + all - POLHODE_MAC_OCTETS);
  return failed != 0 ? failed : (int)all;
}

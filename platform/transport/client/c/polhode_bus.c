/* Where packets come from: sockets, shared memory, files. */
#define _GNU_SOURCE
#include "polhode_bus.h"

#include <arpa/inet.h>
#include <errno.h>
#include <fcntl.h>
#include <linux/futex.h>
#include <netinet/in.h>
#include <poll.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/un.h>
#include <time.h>
#include <unistd.h>

enum { KIND_DATAGRAM, KIND_RING, KIND_FILE };

/* Fixed bits, a possible length and the CRC: octets of the packet at the front of `in`; 0: more are needed to tell; -1: no
 * packet begins here. */
static int packet_at(const uint8_t *in, size_t held) {
  if (held >= 1 && (in[0] & 0xF8) != 0x08) return -1;
  if (held >= 3 && (in[2] & 0xC0) != 0xC0) return -1;
  if (held >= 7 && in[6] != 0x2F) return -1;
  if (held < 16) return 0;
  const size_t octets = ((size_t)in[4] << 8 | in[5]) + 7;
  if (octets <= 18 || octets > POLHODE_PACKET_OCTETS_MAX || in[15] > 1) return -1;
  if (held < octets) return 0;
  return polhode_crc16(in, octets) == 0 ? (int)octets : -1;
}

/* An idle packet (APID 0x7FF), with the beginning of what follows where that is held: its octets; 0: more are needed to tell;
 * -1: none begins here. Longer ones than SKIPPED_OCTETS_MAX are not taken for such, as they would hide packets. */
enum { SKIPPED_OCTETS_MAX = 4096 };
static int idle_at(const uint8_t *in, size_t held) {
  if (held >= 1 && in[0] != 0x07) return -1;
  if (held >= 2 && in[1] != 0xFF) return -1;
  if (held >= 3 && (in[2] & 0xC0) != 0xC0) return -1;
  if (held < 6) return 0;
  const size_t octets = ((size_t)in[4] << 8 | in[5]) + 7;
  if (octets > SKIPPED_OCTETS_MAX) return -1;
  if (held < octets) return 0;
  return held == octets || in[octets] == 0x07 || (in[octets] & 0xF8) == 0x08 ? (int)octets : -1;
}

/* Whose a primary header may be. */
enum owner { OWNER_NOBODY, OWNER_RUN, OWNER_FILL, OWNER_OTHER };
enum { PRIMARY_HEADER_OCTETS = 6, APIDS_OF_A_RUN = 16 };

static enum owner owner_of(const uint8_t *header, int apid_first) {
  static const uint8_t hole[PRIMARY_HEADER_OCTETS]; /* in a file: it reads as zeros */
  const int apid = (header[0] & 7) << 8 | header[1];
  const int unsegmented = (header[2] & 0xC0) == 0xC0;
  if ((header[0] & 0xE0) != 0) return OWNER_NOBODY; /* the version */
  if (apid == 0x7FF) return header[0] == 0x07 && unsegmented ? OWNER_FILL : OWNER_NOBODY;
  if (apid >= apid_first && apid < apid_first + APIDS_OF_A_RUN && (header[0] & 0x10) == 0) {
    return (header[0] & 0xF8) == 0x08 && unsegmented ? OWNER_RUN : OWNER_NOBODY;
  }
  return memcmp(header, hole, sizeof hole) == 0 ? OWNER_NOBODY : OWNER_OTHER;
}

/* As idle_at(), of a packet of another application without our secondary header or CRC, or of an idle one before such. Its
 * primary header tells it, and those of a few packets behind it, followed from length to length. */
static int skipped_at(const uint8_t *in, size_t held, int apid_first, int at_end) {
  enum { LOOK_AHEAD = 4 }; /* packets; each makes an accident some ten times less likely */
  size_t first = 0;
  size_t at = 0;
  for (int i = 0; i < LOOK_AHEAD; ++i) {
    if (i > 0 && at == held) return at_end ? (int)first : 0;
    if (held - at < PRIMARY_HEADER_OCTETS) return at_end ? -1 : 0;
    const enum owner owner = owner_of(in + at, apid_first);
    if (i > 0 && (owner == OWNER_RUN || owner == OWNER_FILL)) return (int)first;
    const size_t octets = ((size_t)in[at + 4] << 8 | in[at + 5]) + 7;
    if (owner == OWNER_NOBODY || owner == OWNER_RUN || octets > SKIPPED_OCTETS_MAX) return -1;
    if (i == 0) first = octets;
    at += octets;
    if (at > held) return at_end ? -1 : 0;
  }
  return (int)first;
}

static void count(struct polhode_bus *bus, const uint8_t *packet) {
  const unsigned apid = (unsigned)(packet[0] & 7) << 8 | packet[1];
  const int sequence = (packet[2] & 0x3F) << 8 | packet[3];
  if (bus->last[apid] >= 0) {
    bus->missing += (unsigned)(sequence - bus->last[apid] - 1) & 0x3FFF;
  }
  bus->last[apid] = (int16_t)sequence;
  ++bus->packets;
}

/* The next packet of what is held, which loses it, the damage before it and what is passed over. Another application's packet
 * is believed only where packets were whole up to it. @param at_end nothing will follow. 0: more is needed. */
static int cut_packet(struct polhode_bus *bus, uint8_t *packet, size_t capacity, int at_end) {
  size_t at = 0;
  int octets = -1;
  while (at < bus->held) {
    const uint8_t *in = bus->stream + at;
    const size_t left = bus->held - at;
    octets = packet_at(in, left);
    if (octets > 0 || (octets == 0 && !at_end)) break;
    const int idle = idle_at(in, left);
    if (idle == 0 && !at_end) break;
    const int skipped = idle > 0 ? idle : bus->in_step ? skipped_at(in, left, bus->apid_first, at_end) : -1;
    if (skipped == 0) break;
    const int is_idle = skipped > 0 && in[0] == 0x07 && in[1] == 0xFF;
    bus->in_step = skipped > 0;
    bus->damaged_octets += skipped > 0 ? 0 : 1;
    bus->idle += is_idle;
    bus->foreign += skipped > 0 && !is_idle;
    at += skipped > 0 ? (size_t)skipped : 1;
    octets = -1;
  }
  const int whole = octets > 0 && (size_t)octets <= capacity;
  if (whole) {
    bus->in_step = 1;
    memcpy(packet, bus->stream + at, (size_t)octets);
    at += (size_t)octets;
  }
  bus->held -= at;
  memmove(bus->stream, bus->stream + at, bus->held);
  return whole ? octets : octets > 0 ? -EMSGSIZE : 0;
}

/* ---- datagrams ---- */

static int64_t now_ms(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (int64_t)now.tv_sec * 1000 + now.tv_nsec / 1000000;
}

static int bind_unix(struct polhode_bus *bus, const char *path) {
  struct sockaddr_un to = {.sun_family = AF_UNIX};
  if (strlen(path) >= sizeof to.sun_path) return -ENAMETOOLONG;
  strcpy(to.sun_path, path);
  struct stat status;
  if (lstat(path, &status) == 0) {
    if (!S_ISSOCK(status.st_mode)) return -EEXIST;
    const int probe = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    const int dead = connect(probe, (struct sockaddr *)&to, sizeof to) != 0 && errno == ECONNREFUSED;
    close(probe);
    if (!dead) return -EADDRINUSE;
    unlink(path); /* left behind by a reader that died */
  }
  const mode_t before = umask(0177);
  const int failed = bind(bus->fd, (struct sockaddr *)&to, sizeof to) != 0 ? -errno : 0;
  umask(before);
  if (failed == 0) strcpy(bus->path, path);
  return failed;
}

static int bind_udp(struct polhode_bus *bus, const char *rest) {
  struct sockaddr_in to = {.sin_family = AF_INET, .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
  char host[32] = "";
  const char *colon = strrchr(rest, ':');
  if (colon != NULL) {
    if ((size_t)(colon - rest) >= sizeof host) return -EINVAL;
    memcpy(host, rest, (size_t)(colon - rest));
    if (inet_pton(AF_INET, host, &to.sin_addr) != 1) return -EINVAL;
    rest = colon + 1;
  }
  const long port = strtol(rest, NULL, 10);
  if (port < 1 || port > 65535) return -EINVAL;
  to.sin_port = htons((uint16_t)port);
  return bind(bus->fd, (struct sockaddr *)&to, sizeof to) != 0 ? -errno : 0;
}

/* Of a stranger the system holds 10 datagrams for a Unix socket, of the one it is connected to hundreds: the first sender that
 * has a name is the one, as long as it lives. */
static void connect_to(struct polhode_bus *bus, const struct sockaddr_un *from, socklen_t octets) {
  const size_t path_at = offsetof(struct sockaddr_un, sun_path);
  if (bus->path[0] == '\0' || bus->connected || octets <= path_at + 1 || from->sun_path[0] == '\0') return;
  bus->connected = connect(bus->fd, (const struct sockaddr *)from, octets) == 0;
}

/* After some silence: an empty datagram tells whether the sender lives (it never reads any). The system itself undoes the
 * connection to a dead one; another may then send. */
static void let_go_of_dead(struct polhode_bus *bus) {
  if (bus->connected && send(bus->fd, "", 0, MSG_DONTWAIT | MSG_NOSIGNAL) < 0 && errno == ECONNREFUSED) bus->connected = 0;
}

static int next_datagram(struct polhode_bus *bus, uint8_t *packet, size_t capacity, int timeout_ms) {
  enum { SILENCE_MS = 200 };
  int left_ms = timeout_ms;
  for (;;) {
    const int cut = cut_packet(bus, packet, capacity, 1);
    if (cut != 0) return cut;
    struct sockaddr_un from;
    socklen_t from_octets = sizeof from;
    const ssize_t octets =
        recvfrom(bus->fd, bus->stream, sizeof bus->stream, MSG_DONTWAIT, (struct sockaddr *)&from, &from_octets);
    if (octets > 0) {
      bus->held = (size_t)octets;
      bus->in_step = 1;
      const int good = cut_packet(bus, packet, capacity, 1);
      if (good > 0) {
        connect_to(bus, &from, from_octets);
        bus->heard_ms = now_ms();
        return good;
      }
      continue;
    }
    if (octets == 0) continue;
    if (errno != EAGAIN && errno != EINTR) return -errno;
    if (bus->connected && now_ms() - bus->heard_ms >= SILENCE_MS) let_go_of_dead(bus);
    const int slice_ms = bus->connected && (left_ms < 0 || left_ms > SILENCE_MS) ? SILENCE_MS : left_ms;
    struct pollfd wait = {.fd = bus->fd, .events = POLLIN};
    const int ready = poll(&wait, 1, slice_ms);
    if (ready < 0 && errno != EINTR) return -errno;
    if (ready == 0 && slice_ms == left_ms) return 0;
    if (ready == 0 && left_ms > 0) left_ms -= slice_ms;
  }
}

/* ---- shared memory; the layout is described in platform/transport/shm/ring_layout.hpp ---- */

#define RING_MAGIC 0x31474E5248444C50u
#define RING_WORDS 175

struct ring_slot {
  _Alignas(64) _Atomic uint64_t version;
  _Atomic uint64_t octets;
  _Atomic uint64_t words[RING_WORDS];
};

struct ring {
  _Alignas(64) _Atomic uint64_t magic;
  uint64_t slots, slot_octets, words;
  _Alignas(64) _Atomic uint64_t head;
  _Atomic uint32_t futex;
  _Alignas(64) struct ring_slot slot[];
};

static size_t ring_octets(const struct ring *ring) { return sizeof(struct ring) + ring->slots * sizeof(struct ring_slot); }

static int open_ring(struct polhode_bus *bus, const char *name) {
  char path[160] = "/dev/shm";
  if (name[0] != '/' || strlen(name) > 128) return -EINVAL;
  strcat(path, name);
  bus->fd = open(path, O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (bus->fd < 0) return -errno;
  struct stat status;
  if (fstat(bus->fd, &status) != 0) return -errno;
  /* As the writer makes it. Of another user, or open to others, it could hold anything. */
  if (!S_ISREG(status.st_mode) || status.st_uid != geteuid() || (status.st_mode & 077) != 0) return -EPERM;
  if ((size_t)status.st_size < sizeof(struct ring)) return -EPROTO;
  void *memory = mmap(NULL, (size_t)status.st_size, PROT_READ, MAP_SHARED | MAP_POPULATE, bus->fd, 0);
  if (memory == MAP_FAILED) return -errno;
  const struct ring *ring = memory;
  if (atomic_load_explicit(&ring->magic, memory_order_acquire) != RING_MAGIC || ring->words != RING_WORDS ||
      ring->slot_octets != sizeof(struct ring_slot) || ring_octets(ring) > (size_t)status.st_size) {
    munmap(memory, (size_t)status.st_size);
    return -EPROTO;
  }
  bus->ring = ring;
  bus->next = atomic_load_explicit(&ring->head, memory_order_acquire); /* from now on */
  return 0;
}

/* Packet bus->next into `packet`. Octets; -1: it was overwritten; -2: there is none yet. */
static int read_slot(struct polhode_bus *bus, uint8_t *packet, size_t capacity) {
  const struct ring *ring = bus->ring;
  const uint64_t head = atomic_load_explicit(&ring->head, memory_order_acquire);
  if (bus->next >= head) return -2;
  if (head - bus->next > ring->slots) return -1;
  const struct ring_slot *slot = &ring->slot[bus->next % ring->slots];
  const uint64_t version = atomic_load_explicit(&slot->version, memory_order_acquire);
  if (version != 2 * bus->next + 2) return -1;
  const uint64_t octets = atomic_load_explicit(&slot->octets, memory_order_relaxed);
  if (octets > capacity || octets > 8 * RING_WORDS) return -1;
  for (size_t at = 0, word = 0; at < octets; at += 8, ++word) {
    const uint64_t value = atomic_load_explicit(&slot->words[word], memory_order_relaxed);
    memcpy(packet + at, &value, octets - at < 8 ? octets - at : 8);
  }
  atomic_thread_fence(memory_order_acquire);
  return atomic_load_explicit(&slot->version, memory_order_relaxed) == version ? (int)octets : -1;
}

/* Until a packet beyond bus->next is there. 1: perhaps; 0: the time is over. */
static int wait_ring(struct polhode_bus *bus, int64_t until_ms, int for_ever) {
  const struct ring *ring = bus->ring;
  const int64_t left_ms = until_ms - now_ms();
  if (!for_ever && left_ms <= 0) return 0;
  struct timespec time = {left_ms / 1000, left_ms % 1000 * 1000000};
  syscall(SYS_futex, &ring->futex, FUTEX_WAIT, (uint32_t)bus->next, for_ever ? NULL : &time, NULL, 0);
  return 1;
}

static int next_ring(struct polhode_bus *bus, uint8_t *packet, size_t capacity, int timeout_ms) {
  const int64_t until_ms = now_ms() + timeout_ms;
  const struct ring *ring = bus->ring;
  for (;;) {
    const int octets = read_slot(bus, packet, capacity);
    if (octets >= 0) {
      ++bus->next;
      if (packet_at(packet, (size_t)octets) == octets) return octets;
      bus->damaged_octets += (uint64_t)octets;
    } else if (octets == -1) { /* overtaken: go on in the newer half of what is there */
      const uint64_t head = atomic_load_explicit(&ring->head, memory_order_acquire);
      const uint64_t oldest = head > ring->slots / 2 ? head - ring->slots / 2 : 0;
      const uint64_t to = oldest > bus->next ? oldest : bus->next + 1;
      bus->overrun += to - bus->next;
      bus->next = to;
    } else if (timeout_ms == 0 || !wait_ring(bus, until_ms, timeout_ms < 0)) {
      return 0;
    }
  }
}

/* ---- files ---- */

static int next_in_file(struct polhode_bus *bus, uint8_t *packet, size_t capacity, int timeout_ms) {
  const int64_t until_ms = now_ms() + timeout_ms;
  for (;;) {
    const int octets = cut_packet(bus, packet, capacity, 0);
    if (octets != 0) return octets;
    const ssize_t more = read(bus->fd, bus->stream + bus->held, sizeof bus->stream - bus->held);
    if (more < 0) return -errno;
    bus->held += (size_t)more;
    if (more == 0) {
      if (timeout_ms >= 0 && now_ms() >= until_ms) return 0;
      nanosleep(&(struct timespec){0, 10000000}, NULL); /* a file says nothing when it grows */
    }
  }
}

/* ---- all kinds ---- */

int polhode_bus_open(struct polhode_bus *bus, const char *address) {
  memset(bus, 0, sizeof *bus);
  memset(bus->last, 0xFF, sizeof bus->last);
  bus->fd = -1;
  bus->apid_first = POLHODE_APID_FIRST;
  bus->in_step = 1;
  int failed = -EINVAL;
  if (strncmp(address, "unix:", 5) == 0 || strncmp(address, "udp:", 4) == 0) {
    const int is_unix = address[1] == 'n';
    bus->kind = KIND_DATAGRAM;
    bus->fd = socket(is_unix ? AF_UNIX : AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    failed = bus->fd < 0 ? -errno : is_unix ? bind_unix(bus, address + 5) : bind_udp(bus, address + 4);
  } else if (strncmp(address, "shm:", 4) == 0) {
    bus->kind = KIND_RING;
    failed = open_ring(bus, address + 4);
  } else if (strncmp(address, "file:", 5) == 0) {
    bus->kind = KIND_FILE;
    bus->fd = open(address + 5, O_RDONLY | O_CLOEXEC);
    failed = bus->fd < 0 ? -errno : 0;
  }
  if (failed != 0) polhode_bus_close(bus);
  return failed;
}

int polhode_bus_next(struct polhode_bus *bus, uint8_t *packet, size_t capacity, int timeout_ms) {
  const int octets = bus->kind == KIND_DATAGRAM ? next_datagram(bus, packet, capacity, timeout_ms)
                     : bus->kind == KIND_RING   ? next_ring(bus, packet, capacity, timeout_ms)
                                                : next_in_file(bus, packet, capacity, timeout_ms);
  if (octets > 0) count(bus, packet);
  return octets;
}

int polhode_bus_to_end(struct polhode_bus *bus) {
  bus->held = 0;
  memset(bus->last, 0xFF, sizeof bus->last);
  if (bus->kind == KIND_RING) {
    bus->next = atomic_load_explicit(&((const struct ring *)bus->ring)->head, memory_order_acquire);
  } else if (bus->kind == KIND_FILE) {
    return lseek(bus->fd, 0, SEEK_END) < 0 ? -errno : 0;
  } else {
    uint8_t octet;
    while (recv(bus->fd, &octet, sizeof octet, MSG_DONTWAIT) >= 0) {
    }
  }
  return 0;
}

void polhode_bus_close(struct polhode_bus *bus) {
  if (bus->ring != NULL) munmap((void *)bus->ring, ring_octets(bus->ring));
  if (bus->fd >= 0) close(bus->fd);
  if (bus->path[0] != '\0') unlink(bus->path);
  bus->ring = NULL;
  bus->fd = -1;
  bus->path[0] = '\0';
}

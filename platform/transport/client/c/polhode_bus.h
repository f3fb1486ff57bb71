/* Reads Polhode's motion output bus: C11, no dependencies, no heap, no threads.
 *
 *   struct polhode_bus bus;
 *   if (polhode_bus_open(&bus, "unix:/run/polhode/telemetry") != 0) ...
 *   uint8_t packet[POLHODE_PACKET_OCTETS_MAX];
 *   int octets = polhode_bus_next(&bus, packet, sizeof packet, 1000);
 *   struct polhode_motion motion;
 *   if (octets > 0 && polhode_decode(packet, octets, POLHODE_MOTION, &motion, sizeof motion) == 0) ...
 *   polhode_bus_close(&bus);
 *
 * A reader is never waited for: one that is too slow loses packets, and sees how many in `missing`. */
#ifndef POLHODE_BUS_H
#define POLHODE_BUS_H

#include <stddef.h>
#include <stdint.h>

#include "polhode_packets.h"

#ifdef __cplusplus
extern "C" {
#endif

#define POLHODE_PACKET_OCTETS_MAX 1400
#define POLHODE_APIDS 2048

/* The caller's memory; read the counters, leave the rest alone. `apid_first` may be set after opening. */
struct polhode_bus {
  uint64_t packets;        /* handed over */
  uint64_t missing;        /* by their counts, per APID modulo 16384 */
  uint64_t damaged_octets; /* that belonged to no whole packet */
  uint64_t overrun;        /* packets of a shared-memory ring that were overwritten before they were read */
  uint64_t idle;           /* CCSDS idle packets, passed over */
  uint64_t foreign;        /* packets of other applications without our secondary header or CRC, passed over */
  int apid_first;          /* of the run: what bears one of its 16 APIDs is its packet, or damage */

  int kind;
  int fd;
  char path[128];           /* of a Unix socket, removed when closed */
  int connected;            /* a Unix socket, to the sender that is heard */
  int64_t heard_ms;         /* last, on the monotonic clock */
  const void *ring;         /* shared memory */
  uint64_t next;            /* packet of the ring to be read next */
  size_t held;              /* octets in `stream` */
  int in_step;              /* packets were whole up to there */
  uint8_t stream[65536];    /* of a file or the last datagram, not yet cut into packets */
  int16_t last[POLHODE_APIDS]; /* sequence count last seen, -1: none */
};

/* Addresses: unix:PATH and udp:PORT or udp:HOST:PORT are bound here (the sender sends to them), shm:/NAME and
 * file:PATH are opened. A Unix socket's file is made for its owner alone. 0, or a negative errno; -EPERM: a ring of another
 * user, or one that is open to others. */
int polhode_bus_open(struct polhode_bus *bus, const char *address);

/* The next whole packet, its CRC checked; a datagram may hold several. Damage, idle packets and those of other
 * applications are skipped and counted. Waits at most timeout_ms (0: not at all; -1: for ever). Octets of the packet; 0: none came in time (of a file: its end for
 * now); a negative errno. */
int polhode_bus_next(struct polhode_bus *bus, uint8_t *packet, size_t capacity, int timeout_ms);

/* Passes over what is there already and was not read: of a file all of it, so that only what is written from now on
 * comes. Nothing of it is counted. 0, or a negative errno. */
int polhode_bus_to_end(struct polhode_bus *bus);

void polhode_bus_close(struct polhode_bus *bus);

/* Which packet of the field table: POLHODE_MOTION, ...; -1: none of them. For APIDs that begin at POLHODE_APID_FIRST. */
int polhode_kind(const uint8_t *packet, size_t octets);

/* Fills the struct of this kind (struct polhode_motion, ...). 0; -1: length, header, layout version or CRC is wrong,
 * or it is another kind of packet, or `struct_octets` is not the struct's size. */
int polhode_decode(const uint8_t *packet, size_t octets, int kind, void *out, size_t struct_octets);

/* CRC-16/CCITT-FALSE; over a whole packet it is 0. */
uint16_t polhode_crc16(const uint8_t *octets, size_t count);

#ifdef __cplusplus
}
#endif
#endif

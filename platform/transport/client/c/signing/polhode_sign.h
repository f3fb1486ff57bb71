/* Signs commands: C11, with OpenSSL (-lcrypto). Reading the bus does not need it.
 *
 *   struct polhode_key key;
 *   if (polhode_key_read(&key, "/etc/polhode/commands.key") != 0) ...
 *   number = polhode_next_number(number);
 *   octets = polhode_sign(&key, number, packet, octets, sizeof packet);
 *
 * A signed command is the command packet with a trailer: its number (8 octets) and a MAC (16
 * octets). The length in the primary header counts the trailer; the packet's own CRC stays as it
 * was without one. The MAC is HMAC-SHA-256, its first 128 bits, over everything before it.
 * docs/security.md has the reasons. */
#ifndef POLHODE_SIGN_H
#define POLHODE_SIGN_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define POLHODE_KEY_OCTETS 32
#define POLHODE_NUMBER_OCTETS 8
#define POLHODE_MAC_OCTETS 16
#define POLHODE_TRAILER_OCTETS (POLHODE_NUMBER_OCTETS + POLHODE_MAC_OCTETS)

struct polhode_key {
  uint8_t octets[POLHODE_KEY_OCTETS];
};

/* A key file holds 64 hexadecimal digits and is its owner's alone (mode 0600 or 0400), as `openssl
 * rand -hex 32` makes them. 0, or a negative errno: -EINVAL: not 64 digits; -EPERM: no file of its
 * own user's or root's, or open to others. */
int polhode_key_read(struct polhode_key* key, const char* file);

/* A number for the next command: greater than `last` (0: none yet), and the UTC time in ns wherever
 * that is greater. So numbers increase over programs and restarts without a store, as long as the
 * clock does not run back. */
uint64_t polhode_next_number(uint64_t last);

/* Adds the trailer to a command packet. Octets of the signed packet; -EINVAL: no packet; -EMSGSIZE:
 * no room for the trailer. */
int polhode_sign(const struct polhode_key* key,
                 uint64_t number,
                 uint8_t* packet,
                 size_t octets,
                 size_t capacity);

/* The MAC of these octets. 0; -EIO: OpenSSL failed. */
int polhode_mac(const struct polhode_key* key,
                const uint8_t* octets,
                size_t count,
                uint8_t mac[POLHODE_MAC_OCTETS]);

#ifdef __cplusplus
}
#endif
#endif

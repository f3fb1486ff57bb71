/* Prints the target's angular velocity: cc -o example example.c polhode_bus.c polhode_packet.c polhode_packets.c */
#include <stdio.h>

#include "polhode_bus.h"

int main(int argc, char **argv) {
  struct polhode_bus bus;
  const int failed = polhode_bus_open(&bus, argc > 1 ? argv[1] : "unix:/run/polhode/telemetry");
  if (failed != 0) {
    fprintf(stderr, "the bus cannot be opened: errno %d\n", -failed);
    return 1;
  }
  uint8_t packet[POLHODE_PACKET_OCTETS_MAX];
  int octets = 0;
  while ((octets = polhode_bus_next(&bus, packet, sizeof packet, 2000)) > 0) {
    struct polhode_motion motion;
    if (polhode_decode(packet, (size_t)octets, POLHODE_MOTION, &motion, sizeof motion) != 0) continue;
    if (motion.flags & POLHODE_MOTION_RATE) {
      printf("frame %u: %.5f %.5f %.5f rad/s\n", motion.frame, motion.w_T_rad_s[0], motion.w_T_rad_s[1], motion.w_T_rad_s[2]);
    }
  }
  printf("%llu packets, %llu missing\n", (unsigned long long)bus.packets, (unsigned long long)bus.missing);
  if (bus.damaged_octets + bus.idle + bus.foreign > 0) {
    printf("%llu octets damaged; passed over: %llu idle packets, %llu of other applications\n", (unsigned long long)bus.damaged_octets,
           (unsigned long long)bus.idle, (unsigned long long)bus.foreign);
  }
  polhode_bus_close(&bus);
  return octets < 0;
}

#include "main.h"
#include "robot.h"
#include <string.h>
volatile rc_t rc;
void dbus_feed(const uint8_t *b, uint16_t len)
{
  if (len != 18) return;
  rc.ch[0] = ((b[0] | b[1] << 8) & 0x7ff) - 1024;
  rc.ch[1] = ((b[1] >> 3 | b[2] << 5) & 0x7ff) - 1024;
  rc.ch[2] = ((b[2] >> 6 | b[3] << 2 | b[4] << 10) & 0x7ff) - 1024;
  rc.ch[3] = ((b[4] >> 1 | b[5] << 7) & 0x7ff) - 1024;
  rc.sw[0] = (b[5] >> 4) & 3;
  rc.sw[1] = (b[5] >> 6) & 3;
  rc.last_ms = HAL_GetTick();
}

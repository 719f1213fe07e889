#include "robot.h"
#include "main.h"
#include <math.h>
static float integ[3];
static const float ang[3] = {-75.0f, 180.0f, 75.0f};
void drive_step(void)
{
  int16_t out[3] = {0};
  if (HAL_GetTick() - rc.last_ms < 100 && rc.sw[0] != 2) {
    float vx = rc.ch[1] / 660.0f, vy = -rc.ch[0] / 660.0f, w = -rc.ch[2] / 660.0f * 2.0f;
    for (int i = 0; i < 3; i++) {
      float a = ang[i] * 3.14159265f / 180.0f;
      float v = -sinf(a) * vx + cosf(a) * vy + 0.061f * w;
      float want_rpm = -v / 0.027f * 60.0f / (2 * 3.14159265f) * 36.0f;
      float e = want_rpm - motors[i].rpm;
      integ[i] += e * 0.001f;
      if (integ[i] > 500) integ[i] = 500;
      if (integ[i] < -500) integ[i] = -500;
      float u = 0.5f * e + 2.0f * integ[i];
      if (u > 600) u = 600;
      if (u < -600) u = -600;
      out[i] = (int16_t)u;
    }
  } else { integ[0] = integ[1] = integ[2] = 0; }
  motors_send(out);
}

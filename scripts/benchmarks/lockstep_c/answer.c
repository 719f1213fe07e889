/* A firmware that only answers: a frame in each millisecond, so that the link is all there is. */
#include "wheelbench.h"

int main(void) {
    static const uint8_t data[8];
    for (;;) {
        wb_can_write(0x200, data, sizeof data);
        wb_wait();
    }
}

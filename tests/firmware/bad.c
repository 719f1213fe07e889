/* Does what it is told over RC, one letter a tick: every way to end badly, and some ways not to. */
#include "wheelbench.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static volatile uint8_t order;
static volatile int zero;
static volatile uint32_t ticks;
static uint8_t eight[8];

static int divide(int by) {
    return 100 / by;
}

static int sink(volatile int *depth) {
    volatile char frame[4096];
    frame[0] = (char)*depth;
    return sink(depth) + frame[0];
}

void every_ms(void) {
    uint8_t byte;
    ticks++;
    if (wb_uart_read(WB_RC, &byte, 1) == 1)
        order = byte;
    if (order == 'i')
        for (;;) {
        }
    if (order == 'w')
        wb_sleep_ms(1);
}

static void flood(void) {
    for (;;)
        wb_can_write(0x123, eight, 8);
}

static void misbehave(int which) {
    switch (which) {
    case 'n':
        *(volatile int *)8 = 1;
        break;
    case 'd':
        zero = divide(zero);
        break;
    case 's':
        sink(&zero);
        break;
    case 'a':
        assert(zero == 1);
        break;
    case 'o':
        wb_irq_off();
        for (;;) {
        }
    case 'x':
        exit(3);
    case 'f':
        flood();
        break;
    case 'F':
        for (;;)
            wb_uart_write(WB_SLAMWARE, eight, 8);
    case 'z':
        sleep(1000);
        break;
    case 'b':
        __asm__ volatile("1: jmp 1b");
        break;
    case 'p':
        for (int i = 0; i < 100000; i++)
            printf("line %d of a talkative firmware\n", i);
        order = 0;
        break;
    case 'c':
        close(200);
        break;
    case 'm':
        for (;;) {
        } /* the main loop hangs; interrupts go on */
    case 'g': {
        static const uint8_t garbage[700] = {0xFF, 0x10, 0x00};
        for (uint16_t i = 0; i < 8; i++)
            wb_can_write((uint16_t)(0xFFF8 + i), eight, 255);
        wb_uart_write(WB_SLAMWARE, garbage, sizeof garbage);
        order = 0;
        break;
    }
    }
}

int main(void) {
    for (;;) {
        uint32_t now = ticks;
        if (order == 'r')
            return 0;
        misbehave(order);
        eight[0] = (uint8_t)now;
        wb_can_write(0x200, eight, 8);
        while (ticks == now)
            wb_wait();
    }
}

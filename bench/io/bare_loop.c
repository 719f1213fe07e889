/* The least that can wake up a thousand times a second: what this machine itself is late by. `wheelbench doctor timing`.
   Usage: bare_loop SECONDS PRIORITY (real-time, 0 for none). Prints "MICROSECONDS TICKS" for every lateness that occurred, and "max NANOSECONDS". */
#define _GNU_SOURCE
#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/prctl.h>
#include <time.h>

#define LONGEST_US 50000

static long long now_ns(void) {
    struct timespec at;
    clock_gettime(CLOCK_MONOTONIC, &at);
    return at.tv_sec * 1000000000LL + at.tv_nsec;
}

int main(int count, char **words) {
    static long counts[LONGEST_US + 1];
    long ticks = (long)(1000 * (count > 1 ? atof(words[1]) : 1.0));
    long long most = 0;
    prctl(PR_SET_TIMERSLACK, 1, 0, 0, 0);
    struct sched_param priority = {count > 2 ? atoi(words[2]) : 0};
    if (priority.sched_priority && sched_setscheduler(0, SCHED_FIFO, &priority)) return 1;
    long long deadline = now_ns();
    for (long tick = 0; tick < ticks; tick++) {
        deadline += 1000000;
        struct timespec at = {deadline / 1000000000, deadline % 1000000000};
        clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, NULL);
        long long late = now_ns() - deadline;
        if (late < 0) late = 0;
        if (late > most) most = late;
        counts[late / 1000 < LONGEST_US ? late / 1000 : LONGEST_US]++;
    }
    for (long us = 0; us <= LONGEST_US; us++)
        if (counts[us]) printf("%ld %ld\n", us, counts[us]);
    printf("max %lld\n", most);
    return 0;
}

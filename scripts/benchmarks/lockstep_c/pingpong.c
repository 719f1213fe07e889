/* The same packets as the lock-step link's, between two processes in C: what the machine itself takes for them. They
 * share the core that the first of them began on.
 *
 *     pingpong ROUNDS QUESTION_BYTES ANSWER_BYTES     prints seconds a round
 */
#define _GNU_SOURCE
#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

static char packet[65536];

int main(int count, char **values) {
    if (count != 4)
        return 64;
    long rounds = atol(values[1]);
    size_t question = (size_t)atol(values[2]), answer = (size_t)atol(values[3]);
    cpu_set_t core;
    CPU_ZERO(&core);
    CPU_SET(sched_getcpu(), &core);
    sched_setaffinity(0, sizeof core, &core);
    int ends[2];
    if (socketpair(AF_UNIX, SOCK_SEQPACKET, 0, ends) != 0)
        return 70;
    if (fork() == 0) {
        close(ends[0]);
        while (recv(ends[1], packet, sizeof packet, 0) > 0)
            if (send(ends[1], packet, answer, 0) < 0)
                break;
        _exit(0);
    }
    close(ends[1]);
    struct timespec begin, end;
    clock_gettime(CLOCK_MONOTONIC, &begin);
    for (long i = 0; i < rounds; i++)
        if (send(ends[0], packet, question, 0) < 0 || recv(ends[0], packet, sizeof packet, 0) < 0)
            return 70;
    clock_gettime(CLOCK_MONOTONIC, &end);
    close(ends[0]);
    wait(NULL);
    printf("%.9f\n", ((double)(end.tv_sec - begin.tv_sec) + 1e-9 * (double)(end.tv_nsec - begin.tv_nsec)) / (double)rounds);
    return 0;
}

"""Firmwares of tasks: what FreeRTOS and CMSIS-RTOS promise in their documentation, tick by tick on the CAN wire."""

import textwrap

import pytest
from compilers import needs_compiler

from bench.dut.build import build
from bench.dut.firmware import firmware_of
from bench.dut.project import load_project

pytestmark = needs_compiler

PUT = """
    #include "cmsis_os.h"
    #include "wheelbench.h"
    static void put(int what) { wb_can_write(0x100 + what, (const uint8_t *)"", 0); }
"""


def sent(folder, source, ticks, toml=""):
    """(tick, what) of every put of a firmware, which compiles without a word."""
    (folder / "fw.c").write_text(textwrap.dedent(PUT + source))
    (folder / "fw.toml").write_text('schema = 1\nname = "fw"\nsources = ["fw.c"]\n' + toml)
    assert build(load_project(folder / "fw.toml")).warnings == ""
    base = firmware_of(folder / "fw.toml")()
    return [(tick, frame[0] - 0x100) for tick in range(ticks) for frame in base.step(tick, b"", b"", ())[0]]


def test_version_2_as_a_generator_writes_it(tmp_path):
    source = """
    osThreadId_t hearHandle;
    const osThreadAttr_t hear_attr = {.name = "hear", .stack_size = 8, .priority = (osPriority_t)osPriorityNormal1};
    const osThreadAttr_t say_attributes = {.name = "say", .priority = (osPriority_t)osPriorityNormal};
    osMessageQueueId_t queue;
    osMutexId_t mutex;
    osSemaphoreId_t full;
    osEventFlagsId_t flags;
    static void blink(void *given) { put(0x50 + *(int *)given); }
    static void hear(void *unused) {
        uint16_t item = 0;
        uint32_t last = osKernelGetTickCount();
        uint8_t priority = 9;
        while (osMessageQueueGet(queue, &item, &priority, 3) == osOK && !priority) put(item);
        put(0x20);                                                             /* three ticks without one */
        if (osThreadFlagsWait(0x5, osFlagsWaitAll, osWaitForever) == 0x5) put(0x21);
        if (osEventFlagsWait(flags, 0x8, osFlagsWaitAny, 2) == osFlagsErrorTimeout) put(0x22);
        if (osSemaphoreAcquire(full, 0) == osErrorResource) put(0x23);
        if (osDelayUntil(last + 20) == osOK) put(0x24);
        if (osDelayUntil(last + 20) == osErrorParameter) put(0x25);            /* that time is over */
        osThreadExit();
    }
    static void say(void *unused) {
        for (uint16_t i = 1; i <= 2; i++) {
            osDelay(1);
            osMutexAcquire(mutex, osWaitForever);
            osMessageQueuePut(queue, &i, 0, 0);
            put(0x10 + i);
            osMutexRelease(mutex);
        }
        osDelay(5);
        osThreadFlagsSet(hearHandle, 0x1);
        osDelay(1);
        osThreadFlagsSet(hearHandle, 0x4);
        for (;;) osDelay(1000);
    }
    int main(void) {
        static int seven = 7;
        osKernelInitialize();
        queue = osMessageQueueNew(2, sizeof(uint16_t), NULL);
        mutex = osMutexNew(NULL);
        full = osSemaphoreNew(1, 0, NULL);
        flags = osEventFlagsNew(NULL);
        osTimerStart(osTimerNew(blink, osTimerPeriodic, &seven, NULL), 6);
        hearHandle = osThreadNew(hear, NULL, &hear_attr);
        osThreadNew(say, NULL, &say_attributes);
        osKernelStart();
        for (;;) {}
    }
    """
    assert sent(tmp_path, source, 22) == [
        (1, 1), (1, 0x11), (2, 2), (2, 0x12), (5, 0x20), (6, 0x57), (8, 0x21), (10, 0x22), (10, 0x23), (12, 0x57),
        (18, 0x57), (20, 0x24), (20, 0x25),
    ]  # fmt: skip


def test_version_1_as_older_generators_write_it(tmp_path):
    source = """
    osThreadId lowHandle, highHandle;
    osMessageQId queueHandle;
    osSemaphoreId semHandle;
    osMutexId mutexHandle;
    osStaticMutexDef_t memory;
    static void once(void const *given) { put(0x60 + *(int *)pvTimerGetTimerID((TimerHandle_t)given)); }
    static void Spins(void const *argument) { for (;;) {} }          /* below the timers, which are at 2 */
    static void High(void const *argument) {
        osEvent event;
        uint32_t last = osKernelSysTick();
        for (int i = 0; i < 2; i++) {
            event = osMessageGet(queueHandle, osWaitForever);
            if (event.status == osEventMessage) put((int)event.value.v);
        }
        event = osSignalWait(0x3, 4);
        if (event.status == osEventTimeout) put(0x20);
        event = osSignalWait(0, osWaitForever);
        put(0x20 + event.value.signals);
        osDelayUntil(&last, 15);
        put(0x24);
        osDelayUntil(&last, 2);
        put(0x25);
        for (;;) osDelay(1000);
    }
    static void Low(void const *argument) {
        osSemaphoreWait(semHandle, osWaitForever);
        if (osSemaphoreWait(semHandle, 0) != osOK) put(0x30);
        osMessagePut(queueHandle, 1, 0);
        put(0x31);
        osDelay(1);
        if (osMutexWait(mutexHandle, 10) == osOK) osMessagePut(queueHandle, 2, 0);
        osMutexRelease(mutexHandle);
        osDelay(7);
        osSignalSet(highHandle, 0x2);
        if (osSignalSet(lowHandle, 0x4) == 0 && osSignalSet(lowHandle, 0x1) == 0x4) put(0x32);
        put(0x30 + osSignalWait(0x3, 5).value.signals);            /* one of the two is enough */
        if (osSignalWait(0x3, 0).status == osOK && osSignalSet(lowHandle, 0) == 0x4) put(0x33);
        for (;;) osDelay(1000);
    }
    int main(void) {
        static int two = 2;
        osMutexStaticDef(mutex, &memory);
        mutexHandle = osMutexCreate(osMutex(mutex));
        osSemaphoreDef(sem);
        semHandle = osSemaphoreCreate(osSemaphore(sem), 1);
        osMessageQDef(queue, 4, uint32_t);
        queueHandle = osMessageCreate(osMessageQ(queue), NULL);
        osTimerDef(timer, once);
        osTimerStart(osTimerCreate(osTimer(timer), osTimerOnce, &two), 3);
        osThreadDef(low, Low, osPriorityNormal, 0, 128);
        lowHandle = osThreadCreate(osThread(low), NULL);
        osThreadDef(spins, Spins, osPriorityLow, 0, 128);
        osThreadCreate(osThread(spins), NULL);
        osThreadDef(high, High, osPriorityHigh, 0, 128);
        highHandle = osThreadCreate(osThread(high), NULL);
        osKernelStart();
        for (;;) {}
    }
    """
    assert sent(tmp_path, source, 20) == [
        (0, 0x30), (0, 1), (0, 0x31), (1, 2), (3, 0x62), (5, 0x20), (8, 0x22), (8, 0x32), (8, 0x35), (8, 0x33),
        (15, 0x24), (17, 0x25),
    ]  # fmt: skip


def test_static_tasks_notifications_suspension_and_recursive_mutexes(tmp_path):
    source = """
    static StaticTask_t memory[2];
    static StackType_t stack[2][128];
    static StaticSemaphore_t mutex_memory;
    static SemaphoreHandle_t mutex;
    static TaskHandle_t hearer;
    static void hear(void *unused) {
        uint32_t value = 0;
        if (xTaskNotifyWait(0, 0xF, &value, 2) == pdFALSE) put(0x40);
        while (xTaskNotifyWait(0, 0xF, &value, portMAX_DELAY) == pdTRUE) put((int)value);
    }
    static void say(void *unused) {
        if (xTaskGetSchedulerState() == taskSCHEDULER_RUNNING) put(0x50);
        vTaskDelay(3);
        xTaskNotify(hearer, 0x12, eSetValueWithOverwrite);       /* heard: 0x12; what stays is 0x10 */
        xTaskNotify(hearer, 0x01, eSetBits);                     /* heard: 0x11 */
        vTaskResume(hearer);                                     /* it waits, and goes on waiting */
        vTaskSuspend(hearer);
        xTaskNotify(hearer, 0x03, eSetValueWithOverwrite);
        if (xTaskNotify(hearer, 0x04, eSetValueWithoutOverwrite) == pdFAIL) put(0x51);
        vTaskDelay(2);
        put(0x52);
        vTaskResume(hearer);                                     /* heard: 0x03 */
        put(0x56);
        if (xSemaphoreTakeRecursive(mutex, 0) && xSemaphoreTakeRecursive(mutex, 0)) put(0x53);
        xSemaphoreGiveRecursive(mutex);
        if (xSemaphoreGiveRecursive(mutex) && !xSemaphoreGiveRecursive(mutex)) put(0x54);
        vTaskDelete(NULL);
    }
    int main(void) {
        mutex = xSemaphoreCreateRecursiveMutexStatic(&mutex_memory);
        if (xTaskGetSchedulerState() == taskSCHEDULER_NOT_STARTED) put(0x55);
        hearer = xTaskCreateStatic(hear, "hear", 128, NULL, 2, stack[0], &memory[0]);
        xTaskCreateStatic(say, "say", 128, NULL, 1, stack[1], &memory[1]);
        vTaskStartScheduler();
        for (;;) {}
    }
    """
    assert sent(tmp_path, source, 8) == [
        (0, 0x55), (0, 0x50), (2, 0x40), (3, 0x12), (3, 0x11), (3, 0x51), (5, 0x52), (5, 0x03), (5, 0x56),
        (5, 0x53), (5, 0x54),
    ]  # fmt: skip


@pytest.mark.parametrize(("clear", "second"), [("pdTRUE", 0x70), ("pdFALSE", 0x72)])
def test_bits_serve_all_who_wait_for_them_and_are_then_cleared(tmp_path, clear, second):
    source = """
    static EventGroupHandle_t group;
    static void wait(void *given) {
        int number = *(int *)given;
        if (xEventGroupWaitBits(group, 0x3, CLEAR, pdFALSE, portMAX_DELAY)) put(0x60 + number);
        vTaskDelete(NULL);
    }
    static void set(void *unused) {
        vTaskDelay(1);
        xEventGroupSetBits(group, 0x4);
        put(0x6F);
        vTaskDelay(1);
        xEventGroupSetBits(group, 0x2);
        put(0x70 + (int)(xEventGroupGetBits(group) & 0x3));
        vTaskDelete(NULL);
    }
    int main(void) {
        static int numbers[2] = {2, 3};
        group = xEventGroupCreate();
        xTaskCreate(wait, "two", 128, &numbers[0], 2, NULL);
        xTaskCreate(wait, "three", 128, &numbers[1], 2, NULL);
        xTaskCreate(set, "set", 128, NULL, 1, NULL);
        vTaskStartScheduler();
        for (;;) {}
    }
    """
    told = sent(tmp_path, source.replace("CLEAR", clear), 4)
    assert told == [(1, 0x6F), (2, 0x62), (2, 0x63), (2, second)]


def test_who_has_a_mutex_waits_for_itself_unless_it_is_a_recursive_one(tmp_path):
    """CMSIS-RTOS: not recursive unless its attributes say so. On the chip such a task stands still for ever."""
    source = """
    static osMutexDef(old);
    static void run(void *unused) {
        const osMutexAttr_t recursive = {.attr_bits = osMutexRecursive | osMutexPrioInherit};
        osMutexId_t plain = osMutexNew(NULL), again = osMutexNew(&recursive);
        osMutexId first = osMutexCreate(osMutex(old));
        if (osMutexAcquire(plain, 0) == osOK && osMutexAcquire(plain, 2) == osErrorTimeout) put(1);
        if (osMutexRelease(plain) == osOK && osMutexAcquire(plain, 0) == osOK) put(2);
        if (osMutexAcquire(again, 0) == osOK && osMutexAcquire(again, 0) == osOK) put(3);
        if (osMutexRelease(again) == osOK && osMutexRelease(again) == osOK && osMutexRelease(again) != osOK) put(4);
        if (osMutexWait(first, 0) == osOK && osMutexWait(first, 1) == osErrorOS) put(5);
        osThreadExit();
    }
    int main(void) {
        osThreadNew(run, NULL, NULL);
        osKernelStart();
    }
    """
    assert sent(tmp_path, source, 5) == [(2, 1), (2, 2), (2, 3), (2, 4), (3, 5)]


def test_a_queue_that_is_overwritten_or_emptied_lets_who_waits_for_it_go_on_at_once(tmp_path):
    source = """
    static QueueHandle_t mail, full;
    static void reads(void *unused) {
        for (uint8_t item;;)
            if (xQueueReceive(mail, &item, portMAX_DELAY)) put(item);
    }
    static void writes(void *unused) {
        uint8_t item = 0;
        xQueueSend(full, &item, portMAX_DELAY);
        xQueueSend(full, &item, portMAX_DELAY);
        put(0x20);
        vTaskDelete(NULL);
    }
    static void low(void *unused) {
        uint8_t item = 5;
        vTaskDelay(2);
        xQueueOverwrite(mail, &item);
        put(0x10);
        xQueueReset(full);
        put(0x11);
        vTaskDelete(NULL);
    }
    int main(void) {
        mail = xQueueCreate(1, 1);
        full = xQueueCreate(1, 1);
        xTaskCreate(reads, "reads", 128, NULL, 2, NULL);
        xTaskCreate(writes, "writes", 128, NULL, 2, NULL);
        xTaskCreate(low, "low", 128, NULL, 1, NULL);
        vTaskStartScheduler();
    }
    """
    assert sent(tmp_path, source, 4) == [(2, 5), (2, 0x10), (2, 0x20), (2, 0x11)]


def test_who_runs_follows_priorities_and_what_holds_the_scheduler(tmp_path):
    source = """
    static TaskHandle_t high;
    static void hears(void *unused) {
        for (;;)
            if (ulTaskNotifyTake(pdTRUE, portMAX_DELAY)) put(0x10);
    }
    static void says(void *unused) {
        xTaskNotifyGive(high);
        put(1);
        vTaskPrioritySet(NULL, 3);
        xTaskNotifyGive(high);
        put(2);
        vTaskPrioritySet(NULL, 1);
        put(3);
        vTaskDelay(1);
        taskENTER_CRITICAL();
        xTaskNotifyGive(high);
        put(4);
        taskEXIT_CRITICAL();
        put(5);
        vTaskSuspendAll();
        xTaskNotifyGive(high);
        while (wb_millis() < 4) {}                               /* ticks pass, and nobody else runs */
        if (xTaskGetSchedulerState() == taskSCHEDULER_SUSPENDED) put(6);
        xTaskResumeAll();
        put(7);
        vTaskDelete(NULL);
    }
    int main(void) {
        xTaskCreate(hears, "hears", 128, NULL, 2, &high);
        xTaskCreate(says, "says", 128, NULL, 1, NULL);
        vTaskStartScheduler();
    }
    """
    assert sent(tmp_path, source, 6) == [
        (0, 0x10), (0, 1), (0, 2), (0, 0x10), (0, 3), (1, 4), (1, 0x10), (1, 5), (4, 6), (4, 0x10), (4, 7),
    ]  # fmt: skip


def test_notifications_are_counted_cleared_and_forgotten_as_asked_for(tmp_path):
    source = """
    static void run(void *unused) {
        TaskHandle_t self = xTaskGetCurrentTaskHandle();
        uint32_t value = 9;
        TickType_t past = xTaskGetTickCount();
        xTaskNotifyGive(self);
        xTaskNotifyGive(self);
        put((int)ulTaskNotifyTake(pdFALSE, 0));                  /* 2, and one stays */
        put((int)ulTaskNotifyTake(pdTRUE, 0));
        put((int)ulTaskNotifyTake(pdTRUE, 0));
        vTaskDelay(1);
        xTaskNotify(self, 0x33, eSetBits);
        if (xTaskNotifyWait(0, 0x03, &value, 0)) put((int)value);
        if (!xTaskNotifyWait(0x10, 0, &value, 0)) put((int)value);
        xTaskNotify(self, 0, eNoAction);
        if (xTaskNotifyStateClear(NULL) && !xTaskNotifyStateClear(NULL) && !xTaskNotifyWait(0, 0, &value, 1)) put(0x40);
        vTaskDelay(3);
        if (!xTaskDelayUntil(&past, 2) && past == 2 && xTaskDelayUntil(&past, 5)) put(0x41);
        for (;;) vTaskDelay(1000);
    }
    int main(void) {
        xTaskCreate(run, "run", 128, NULL, 2, NULL);
        vTaskStartScheduler();
    }
    """
    assert sent(tmp_path, source, 9) == [(0, 2), (0, 1), (0, 0), (1, 0x33), (1, 0x20), (2, 0x40), (7, 0x41)]


FULL_QUEUE = """
    static QueueHandle_t queue;
    static void writes(void *unused) {
        for (uint8_t item = 1; item < 4; item++) {
            xQueueSend(queue, &item, portMAX_DELAY);
            put(0x10 + item);
        }
        vTaskDelete(NULL);
    }
    static void reads(void *unused) {
        uint8_t item = 0;
        vTaskDelay(1);
        if (xQueuePeek(queue, &item, 0) && uxQueueSpacesAvailable(queue) == 0) put(item);
        if (xQueueReceive(queue, &item, 0)) put(0x20 + item);
        if (xQueueReceive(queue, &item, 0)) put(0x20 + item);
        if (xQueueReceive(queue, &item, 0) && !xQueueReceive(queue, &item, 2)) put(0x20 + item);
        for (;;) vTaskDelay(1000);
    }
    int main(void) {
        queue = xQueueCreate(2, 1);
        xTaskCreate(writes, "writes", 128, NULL, 2, NULL);
        xTaskCreate(reads, "reads", 128, NULL, 1, NULL);
        vTaskStartScheduler();
    }
"""
BITS = """
    static EventGroupHandle_t group;
    static void waits(void *unused) {
        put((int)xEventGroupWaitBits(group, 0x3, pdTRUE, pdTRUE, portMAX_DELAY));
        put((int)xEventGroupWaitBits(group, 0x4, pdFALSE, pdFALSE, 0));
        put((int)xEventGroupWaitBits(group, 0x4, pdTRUE, pdTRUE, 0));
        put((int)xEventGroupClearBits(group, 0x8));
        put((int)xEventGroupWaitBits(group, 0x4, pdTRUE, pdFALSE, 1));
        put(0x20);
        put((int)(osThreadFlagsWait(1, osFlagsWaitAny | osFlagsNoClear, 0) & osThreadFlagsWait(1, osFlagsWaitAny, 0)));
        if (osThreadFlagsWait(1, osFlagsWaitAny, 0) == osFlagsErrorResource) put(0x21);
        for (;;) vTaskDelay(1000);
    }
    static void sets(void *task) {
        osThreadFlagsSet(*(TaskHandle_t *)task, 1);
        xEventGroupSetBits(group, 0xC);
        xEventGroupSetBits(group, 0x1);
        put(0x10);
        vTaskDelay(1);
        xEventGroupSetBits(group, 0x2);
        for (;;) vTaskDelay(1000);
    }
    int main(void) {
        static TaskHandle_t waiting;
        group = xEventGroupCreate();
        xTaskCreate(waits, "waits", 128, NULL, 2, &waiting);
        xTaskCreate(sets, "sets", 128, &waiting, 1, NULL);
        vTaskStartScheduler();
    }
"""


@pytest.mark.parametrize(
    ("source", "told"),
    [
        (FULL_QUEUE, [(0, 0x11), (0, 0x12), (1, 1), (1, 0x13), (1, 0x21), (1, 0x22), (3, 0x23)]),
        (BITS, [(0, 0x10), (1, 0xF), (1, 0xC), (1, 0xC), (1, 0x8), (2, 0), (2, 0x20), (2, 1), (2, 0x21)]),
    ],
    ids=["a full queue takes again, and a look leaves what is there", "all bits or any, cleared or kept"],
)
def test_who_waits_for_room_or_bits_is_served_as_it_asked(tmp_path, source, told):
    assert sent(tmp_path, source, 4) == told


def test_timers_once_and_again_stopped_and_behind_tasks_of_higher_priority(tmp_path):
    """configTIMER_TASK_PRIORITY is 2 as a generator sets it."""
    source = """
    static TimerHandle_t again, once, late;
    static void told(TimerHandle_t timer) { put(*(int *)pvTimerGetTimerID(timer)); }
    static void run(void *unused) {
        static int ids[3] = {0x10, 0x20, 0x30};
        again = xTimerCreate("again", 2, pdTRUE, &ids[0], told);
        once = xTimerCreate("once", 3, pdFALSE, &ids[1], told);
        late = xTimerCreate("late", 1, pdFALSE, &ids[2], told);
        xTimerStart(again, 0);
        xTimerStart(once, 0);
        xTimerChangePeriod(late, 5, 0);
        vTaskDelay(4);                                           /* 2 and 4 again, 3 once */
        xTimerStop(again, 0);
        if (!xTimerIsTimerActive(again) && !xTimerIsTimerActive(once) && xTimerIsTimerActive(late)) put(1);
        while (wb_millis() < 7) {}
        put(2);
        vTaskDelay(1);
        xTimerReset(once, 0);                                    /* none was active */
        vTaskDelete(NULL);
    }
    int main(void) {
        xTaskCreate(run, "run", 128, NULL, 3, NULL);
        vTaskStartScheduler();
    }
    """
    assert sent(tmp_path, source, 14) == [(2, 0x10), (3, 0x20), (4, 1), (7, 2), (7, 0x30), (11, 0x20)]


def test_mail_pools_and_queues_of_version_1_as_generated_projects_have_them(tmp_path):
    source = """
    typedef struct { uint32_t speed; uint8_t which; } mail_t;
    osMailQDef(mail, 2, mail_t);
    osPoolDef(pool, 2, mail_t);
    osMessageQDef(bytes, 1, uint8_t);
    static osMailQId mails;
    static osPoolId blocks;
    static osMessageQId queue;
    static void Hears(void const *unused) {
        for (osEvent event;;) {
            event = osMailGet(mails, 4);
            mail_t *mail = event.value.p;
            if (event.status == osEventTimeout) { put(0x20); break; }
            if (event.status == osEventMail && event.def.mail_id == mails) put((int)mail->speed + mail->which);
            if (osMailFree(mails, mail) != osOK) put(0x2F);
        }
        if (osMailGet(mails, 0).status == osOK && osMailFree(mails, NULL) == osErrorParameter) put(0x21);
        osDelay(2);
        put((int)osMessageGet(queue, 0).value.v);                         /* 0x134, as a byte */
        put((int)osMessageGet(queue, 2).value.v);                         /* which had waited for room */
        osThreadTerminate(NULL);                                          /* itself */
    }
    static void Says(void const *unused) {
        mail_t *one = osMailAlloc(mails, osWaitForever), *two = osMailCAlloc(mails, 0);
        if (!osMailAlloc(mails, osWaitForever)) put(0x30);                /* which waits for nothing */
        *one = (mail_t){.speed = 5, .which = 1};
        two->which = 2;
        osMailPut(mails, one);
        osMailPut(mails, two);
        osDelay(1);
        one = osPoolAlloc(blocks);
        one->speed = 9;
        if (osPoolFree(blocks, (uint8_t *)one + 1) == osErrorParameter && osPoolFree(blocks, one) == osOK) put(0x31);
        if (!(two = osPoolCAlloc(blocks))->speed && osPoolAlloc(blocks) && !osPoolAlloc(blocks)) put(0x32);
        if (osPoolFree(blocks, two + 9) == osErrorParameter && osPoolFree(NULL, two) == osErrorParameter) put(0x33);
        put((int)osMessageAvailableSpace(queue));
        osMessagePut(queue, 0x134, 0);
        if (osMessagePeek(queue, 0).value.v == 0x34 && osMessageWaiting(queue) == 1) put(0x34);
        if (osMessagePut(queue, 7, 0) == osErrorOS) put(0x35);            /* no time is a tick */
        if (osMessagePut(queue, 7, osWaitForever) == osOK) put(0x36);
        osDelay(0);                                                       /* a tick, too */
        if (osMessageDelete(queue) == osOK) put(0x37);
        osThreadSuspend(NULL);                                            /* itself */
    }
    int main(void) {
        mails = osMailCreate(osMailQ(mail), NULL);
        blocks = osPoolCreate(osPool(pool));
        queue = osMessageCreate(osMessageQ(bytes), NULL);
        osThreadDef(hears, Hears, osPriorityNormal, 0, 128);
        osThreadCreate(osThread(hears), NULL);
        osThreadDef(says, Says, osPriorityBelowNormal, 0, 128);
        osThreadCreate(osThread(says), NULL);
        osKernelStart();
    }
    """
    assert sent(tmp_path, source, 12) == [
        (0, 0x30), (0, 6), (0, 2), (1, 0x31), (1, 0x32), (1, 0x33), (1, 1), (1, 0x34), (2, 0x35), (4, 0x20), (4, 0x21),
        (6, 0x34), (6, 7), (6, 0x36), (7, 0x37),
    ]  # fmt: skip


def test_threads_mutexes_and_semaphores_of_version_1_as_generated_projects_have_them(tmp_path):
    source = """
    static osStaticSemaphoreDef_t memory;
    static osThreadId low;
    static uint32_t at;
    static void tells(void const *timer) { put(0x60); }
    static void Low(void const *given) {
        put((int)(intptr_t)given);
        for (;;) osSignalWait(0x1, osWaitForever);
    }
    static void High(void const *unused) {
        osThreadDef_t made;                                               /* filled in as it runs */
        made.name = "low";
        made.pthread = Low;
        made.tpriority = osPriorityLow;
        made.instances = 0;
        made.stacksize = 128;
        low = osThreadCreate(&made, (void *)0x11);
        if (osThreadGetState(low) == osThreadReady && osThreadGetState(osThreadGetId()) == osThreadRunning) put(0x20);
        if (osThreadGetPriority(low) == osPriorityLow && osThreadGetPriority(NULL) == osPriorityHigh) put(0x21);
        osThreadSetPriority(low, osPriorityRealtime);                     /* at once */
        if (osThreadGetState(low) == osThreadBlocked && osThreadIsSuspended(low) == osErrorOS) put(0x22);
        osThreadSuspend(low);
        if (osThreadGetState(low) == osThreadSuspended && osThreadIsSuspended(low) == osOK) put(0x23);
        osThreadTerminate(low);
        if (osThreadGetState(low) == osThreadDeleted) put(0x24);
        osDelay(1);
        osSemaphoreStaticDef(empty, &memory);
        osSemaphoreDef(there);
        osSemaphoreId one = osSemaphoreCreate(osSemaphore(empty), 1), two = osSemaphoreCreate(osSemaphore(there), 1);
        if (osSemaphoreWait(one, 0) == osErrorOS && osSemaphoreWait(two, 0) == osOK) put(0x25);
        if (osSemaphoreWait(NULL, 0) == osErrorParameter && osMutexWait(NULL, 0) == osErrorParameter) put(0x26);
        osMutexDef(mutex);
        osMutexId again = osRecursiveMutexCreate(osMutex(mutex));
        if (osRecursiveMutexWait(again, 0) == osOK && osRecursiveMutexWait(again, 0) == osOK) put(0x27);
        if (osRecursiveMutexRelease(again) == osOK && osRecursiveMutexRelease(again) == osOK
            && osRecursiveMutexRelease(again) == osErrorOS) put(0x28);
        if (osMutexDelete(again) == osOK && osSemaphoreDelete(one) == osOK) put(0x29);
        osTimerDef(timer, tells);
        osTimerId timer = osTimerCreate(osTimer(timer), osTimerPeriodic, NULL);
        osTimerStart(timer, 2);
        osDelay(5);                                                       /* at 2 and 4 */
        osTimerDelete(timer);
        osSignalSet(osThreadGetId(), 0x7);
        if (osSignalClear(osThreadGetId(), 0x5) == 0x7 && osSignalWait(0x2, 0).value.signals == 0x2) put(0x2A);
        osThreadSuspendAll();
        if (osKernelRunning() && osThreadResumeAll() == osErrorOS) put(0x2B);
        at = osKernelSysTick();
        while (osKernelSysTick() - at < osKernelSysTickMicroSec(3000)) {}
        put(0x2C);
        for (;;) osDelay(1000);
    }
    void vApplicationStackOverflowHook(xTaskHandle task, signed char *name) { (void)(portTICK_RATE_MS + *name); }
    int main(void) {
        osThreadDef(high, High, osPriorityHigh, 0, 128);
        osThreadCreate(osThread(high), NULL);
        put(osKernelRunning());
        osKernelStart();
    }
    """
    assert sent(tmp_path, source, 10, "blocks_per_ms = 100000\n") == [
        (0, 0), (0, 0x20), (0, 0x21), (0, 0x11), (0, 0x22), (0, 0x23), (0, 0x24),
        (1, 0x25), (1, 0x26), (1, 0x27), (1, 0x28), (1, 0x29), (3, 0x60), (5, 0x60), (6, 0x2A), (6, 0x2B), (9, 0x2C),
    ]  # fmt: skip


def test_pools_states_and_locks_of_version_2_and_what_it_says_to_nobody(tmp_path):
    source = """
    static osMemoryPoolId_t pool;
    static osThreadId_t high;
    static void *blocks[2];
    static void never(void *unused) { put(0x7F); }
    static void hears(void *unused) {
        void *block = osMemoryPoolAlloc(pool, 1);
        if (!block) put(0x10);                                            /* a tick in vain */
        block = osMemoryPoolAlloc(pool, osWaitForever);
        if (block == blocks[0]) put(0x11);
        osThreadSuspend(high);
        put(0x12);
        osDelay(0);                                                       /* is nothing at all */
        put(0x13);
        osThreadExit();
    }
    static void says(void *unused) {
        osTimerId_t timer = osTimerNew(never, osTimerPeriodic, NULL, NULL);
        if (osKernelGetState() == osKernelRunning && osKernelLock() == 0
            && osKernelGetState() == osKernelLocked) put(0x20);
        if (osKernelLock() == 1 && osKernelUnlock() == 1 && osKernelRestoreLock(0) == 0) put(0x21);
        osDelay(2);
        if (osMemoryPoolGetCount(pool) == 2 && osMemoryPoolGetSpace(pool) == 0) put(0x22);
        if (osMemoryPoolFree(pool, "") == osErrorParameter
            && osMemoryPoolFree(NULL, blocks[0]) == osErrorParameter) put(0x23);
        osMemoryPoolFree(pool, blocks[0]);                                /* the other has it, and is suspended */
        if (osThreadGetState(high) == osThreadBlocked && osThreadGetPriority(high) == osPriorityHigh1) put(0x24);
        osThreadSetPriority(high, osPriorityLow);
        osThreadResume(high);
        put(0x25);
        osDelay(1);
        if (osMemoryPoolFree(pool, blocks[1]) == osOK
            && osMemoryPoolFree(pool, blocks[1]) == osErrorResource) put(0x26);
        if (osTimerStart(timer, 1) == osOK && osTimerIsRunning(timer) && osTimerStop(timer) == osOK) put(0x27);
        if (osTimerStop(timer) == osErrorResource && osTimerDelete(timer) == osOK) put(0x28);
        osDelay(2);
        if (osThreadSuspend(NULL) + osThreadTerminate(NULL) + osTimerStart(NULL, 1) == 3 * osErrorParameter) put(0x30);
        if (osMutexAcquire(NULL, 0) + osSemaphoreAcquire(NULL, 0) + osMutexRelease(NULL)
            == 3 * osErrorParameter) put(0x31);
        if (osMessageQueuePut(NULL, "", 0, 0) == osErrorParameter
            && osEventFlagsSet(NULL, 1) == osFlagsErrorParameter) put(0x32);
        osMessageQueueId_t queue = osMessageQueueNew(3, 2, NULL);
        osMessageQueuePut(queue, "ab", 0, 0);
        if (osMessageQueueGetCapacity(queue) == 3 && osMessageQueueGetSpace(queue) == 2) put(0x33);
        if (osMessageQueueGetMsgSize(queue) == 2 && osMessageQueueDelete(queue) == osOK) put(0x34);
        osThreadFlagsSet(osThreadGetId(), 0x5);
        if (osThreadFlagsGet() == 0x5 && osThreadGetCount() == 3) put(0x35); /* with the timers' and the idle one */
        for (;;) osDelay(1000);
    }
    int main(void) {
        const osThreadAttr_t attributes = {.name = "hears", .priority = osPriorityHigh1};
        if (osKernelGetState() == osKernelInactive && osKernelInitialize() == osOK) put(osKernelGetState());
        pool = osMemoryPoolNew(2, 3, NULL);
        for (int i = 0; i < 2; i++) blocks[i] = osMemoryPoolAlloc(pool, 0);
        high = osThreadNew(hears, NULL, &attributes);
        osThreadNew(says, NULL, NULL);
        osKernelStart();
    }
    """
    assert sent(tmp_path, source, 8) == [
        (0, 1), (0, 0x20), (0, 0x21), (1, 0x10), (2, 0x22), (2, 0x23), (2, 0x11), (2, 0x24), (2, 0x25), (2, 0x12),
        (2, 0x13), (3, 0x26), (3, 0x27), (3, 0x28), (5, 0x30), (5, 0x31), (5, 0x32), (5, 0x33), (5, 0x34), (5, 0x35),
    ]  # fmt: skip


def test_the_front_of_a_queue_states_and_names_of_tasks(tmp_path):
    source = """
    #include <string.h>
    static void stands(void *unused) { for (;;) vTaskSuspend(NULL); }
    static void run(void *unused) {
        QueueHandle_t queue = xQueueCreate(2, 1);
        char table[200];
        uint8_t item = 1;
        xQueueSend(queue, &item, 0);
        item = 2;
        xQueueSendToFront(queue, &item, 0);
        if (xQueueSendToFrontFromISR(queue, &item, NULL) == errQUEUE_FULL) put(0x10);
        while (xQueueReceive(queue, &item, 0)) put(item);
        if (eTaskGetState(xTaskGetHandle("stands")) == eSuspended && !xTaskGetHandle("nobody")) put(0x11);
        vTaskList(table);
        if (strstr(table, "run            \\tX\\t2") && strstr(table, "stands         \\tS\\t3")) put(0x12);
        xTaskNotify(xTaskGetCurrentTaskHandle(), 0x7, eSetBits);
        if (ulTaskNotifyValueClear(NULL, 0x3) == 0x7 && ulTaskNotifyTake(pdTRUE, 0) == 0x4) put(0x13);
        for (;;) vTaskDelay(1000);
    }
    int main(void) {
        xTaskCreate(stands, "stands", 128, NULL, 3, NULL);
        xTaskCreate(run, "run", 128, NULL, 2, NULL);
        vTaskStartScheduler();
    }
    """
    assert sent(tmp_path, source, 2) == [(0, 0x10), (0, 2), (0, 1), (0, 0x11), (0, 0x12), (0, 0x13)]


MADE_AND_DELETED = """
    enum { ROUNDS = 200, MOST = 64 };
    static int served;
    static void work(void *unused) {
        volatile uint8_t scratch[100];
        for (int i = 0; i < 100; i++) scratch[i] = (uint8_t)i;
        served += scratch[99] == 99;
        vTaskDelete(NULL);
    }
    static void stands(void *unused) {
        uint8_t scratch[200];
        memset(scratch, 1, sizeof scratch);
        for (;;) vTaskDelay(scratch[9]);
    }
    static void told(TimerHandle_t timer) { served += 1000; }
    static void makes(void *unused) {
        TaskHandle_t task, all[MOST];
        for (int i = 0; i < ROUNDS; i++) {
            xTaskCreate(work, "work", 128, NULL, 3, NULL);                /* runs at once, and deletes itself */
            if (xTaskCreate(stands, "stands", 128, NULL, 3, &task)) vTaskDelete(task);
        }
        put(served == ROUNDS);
        put((int)uxTaskGetNumberOfTasks());                               /* this one and the idle task */
        int count = 0;
        while (count < MOST && xTaskCreate(stands, "stands", 128, NULL, 1, &all[count])) count++;
        put(count);
        vTaskDelete(all[0]);
        put(xTaskCreate(stands, "stands", 128, NULL, 1, &all[0]) == pdPASS);
        vTaskDelete(all[1]);
        vTaskDelete(all[2]);
        for (int i = 0; i < ROUNDS; i++) {
            TimerHandle_t timer = xTimerCreate("t", 1, pdTRUE, NULL, told);
            if (!timer || !xTimerStart(timer, 0) || !xTimerDelete(timer, 0)) put(0x7F);
        }
        vTaskDelay(2);
        put(served == ROUNDS);                                            /* a deleted timer calls nobody */
        for (;;) vTaskDelay(1000);
    }
    int main(void) {
        xTaskCreate(makes, "makes", 128, NULL, 2, NULL);
        vTaskStartScheduler();
    }
"""


def test_what_a_deleted_task_or_timer_had_is_there_for_the_next(tmp_path):
    source = "#include <string.h>\n" + MADE_AND_DELETED
    told = sent(tmp_path, source, 4, "blocks_per_ms = 100000\n")
    assert told == [(0, 1), (0, 2), (0, 63), (0, 1), (2, 1)]


def test_equals_take_turns_whoever_runs_between_them_and_whosever_room_a_new_one_has(tmp_path):
    source = """
    static void takes_turns(void *given) {
        for (;;) {
            put((int)(intptr_t)given);
            for (uint32_t now = wb_millis(); wb_millis() == now;) {}
        }
    }
    static void makes(void *unused) {
        static const int numbers[4] = {1, 2, 3, 4};
        TaskHandle_t tasks[4];
        for (int i = 0; i < 4; i++) xTaskCreate(takes_turns, "turns", 128, (void *)(intptr_t)numbers[i], 1, &tasks[i]);
        vTaskDelay(3);                                                    /* 1, 2, 3: the next is 4 */
        vTaskDelete(tasks[1]);
        xTaskCreate(takes_turns, "turns", 128, (void *)(intptr_t)5, 1, NULL);
        for (;;) vTaskDelay(1);
    }
    int main(void) {
        xTaskCreate(makes, "makes", 128, NULL, 2, NULL);
        vTaskStartScheduler();
    }
    """
    assert [what for _, what in sent(tmp_path, source, 9)] == [1, 2, 3, 4, 5, 1, 3, 4, 5]


INTERRUPTED = """
    #include "stm32f4xx_hal.h"
    extern TIM_HandleTypeDef htim6;
    static osMessageQueueId_t queue;
    static osSemaphoreId_t token;
    static osMutexId_t mutex;
    static uint32_t item;
    void HAL_TIM_PeriodElapsedCallback(TIM_HandleTypeDef *timer) {
        CALLS
    }
    static void hears(void *unused) {
        for (;;)
            if (osSemaphoreAcquire(token, osWaitForever) == osOK) put(0x50);
    }
    int main(void) {
        queue = osMessageQueueNew(1, sizeof item, NULL);
        token = osSemaphoreNew(1, 0, NULL);
        mutex = osMutexNew(NULL);
        osThreadNew(hears, NULL, NULL);
        HAL_TIM_Base_Start_IT(&htim6);
        osKernelStart();
    }
"""


@pytest.mark.parametrize(
    ("calls", "told"),
    [
        # CMSIS-RTOS2: from an interrupt with no limit of time, or osErrorParameter; a mutex never.
        ("put(osMessageQueuePut(queue, &item, 0, osWaitForever) == osErrorParameter);", [(2, 1), (4, 1)]),
        ("put(osMessageQueueGet(queue, &item, NULL, 5) == osErrorParameter);", [(2, 1), (4, 1)]),
        ("put(osMessageQueuePut(queue, &item, 0, 0) == osOK);", [(2, 1), (4, 0)]),
        ("put(osSemaphoreAcquire(token, 1) == osErrorParameter);", [(2, 1), (4, 1)]),
        ("put(osMutexAcquire(mutex, 0) == osErrorISR);", [(2, 1), (4, 1)]),
        # Version 1 has no limit there: what cannot be had at once is refused.
        ("put(osMessagePut(queue, 5, osWaitForever) == osOK);", [(2, 1), (4, 0)]),
        ("put(osMessageGet(queue, osWaitForever).status == osOK);", [(2, 1), (4, 1)]),
        ("put(osSemaphoreWait(token, osWaitForever) == osErrorOS);", [(2, 1), (4, 1)]),
        ("put(osMutexWait(mutex, osWaitForever) == osOK);", [(2, 1), (4, 0)]),
        # A task that is woken there runs behind the interrupt.
        ("osSemaphoreRelease(token); portYIELD(); put(2);", [(2, 2), (2, 0x50), (4, 2), (4, 0x50)]),
    ],
)
def test_in_an_interrupt_nothing_waits(tmp_path, calls, told):
    timer = '[[timer]]\nhandle = "htim6"\nperiod_ms = 2\n'
    assert sent(tmp_path, INTERRUPTED.replace("CALLS", calls), 5, timer) == told

/* The example's plant as a library that goes wrong in ways that are nothing to learn from: `ill` names which, at `fault_s`. */
#define haptic_rig_exchange plant_exchange
#define haptic_rig_prepare plant_prepare
#define haptic_rig_disable plant_disable
#define haptic_rig_open plant_open
#include "../../../hal/examples/plug-in/rotary_plant.c"
#undef haptic_rig_exchange
#undef haptic_rig_prepare
#undef haptic_rig_disable
#undef haptic_rig_open

#include <pthread.h>

static char ill[32];
static volatile int never;

static int is_ill(const plant *p, const char *how)
{
    return strcmp(ill, how) == 0 && p->time_s >= p->fault_s;
}

int32_t haptic_rig_open(const haptic_rig_setting *settings, uint32_t count, void **rig)
{
    for (uint32_t i = 0; i < count; i++)
        if (strcmp(settings[i].key, "ill") == 0)
            strncpy(ill, settings[i].value, sizeof ill - 1);
    return plant_open(settings, count, rig);
}

int32_t haptic_rig_prepare(void *rig, int32_t (*stop)(void *context), void *context)
{
    while (strcmp(ill, "blocks-in-prepare") == 0)
        sleep(1);
    return plant_prepare(rig, stop, context);
}

void haptic_rig_disable(void *rig)
{
    plant_disable(rig);
    while (strcmp(ill, "blocks-in-disable") == 0)
        sleep(1);
}

static int overflow(int depth)
{
    volatile char page[4096];
    page[0] = (char)depth;
    return never ? page[0] : overflow(depth + 1) + page[0];
}

static void *crash(void *context)
{
    (void)context;
    abort();
}

int32_t haptic_rig_exchange(void *rig, uint64_t due_ns, double torque, haptic_rig_measurement *measurement)
{
    plant *p = rig;
    int32_t code = plant_exchange(rig, due_ns, torque, measurement);
    static pthread_t thread;
    if (is_ill(p, "aborts"))
        abort();
    if (is_ill(p, "overflows"))
        return overflow(0);
    if (is_ill(p, "naps"))
        usleep(1);
    if (is_ill(p, "exits"))
        exit(0);
    /* One thread: glibc's abort() in several at once may end in SIGSEGV. */
    if (is_ill(p, "thread-aborts") && !thread)
        pthread_create(&thread, NULL, crash, NULL);
    if (is_ill(p, "infinite"))
        measurement->value[TORQUE] = INFINITY;
    if (is_ill(p, "clock-back"))
        measurement->time_ns = p->begun_ns + (uint64_t)(1e9 * (2.0 * p->fault_s - p->time_s));
    if (is_ill(p, "clock-jumps"))
        measurement->time_ns += 1000000000u;
    if (is_ill(p, "angle-jumps"))
        measurement->value[ANGLE] += 100.0 * p->counts_per_turn / (2.0 * M_PI);
    return code;
}

/*
 * A rig without hardware: a motor on a torque sensor with a knob on it, as a library for the haptic camera.
 *
 *     cc -O2 -shared -fPIC -I ../../src/plugin -o rotary_plant.so rotary_plant.c -lm
 *     haptic-camera capture --rig rotary_plant.toml
 *
 * Replace what is between "the device" and "the interface" by the calls of your card, and you have a driver.
 */
#define _GNU_SOURCE
#include "haptic_rig.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

/* ---- the device: rotor and knob on one shaft -------------------------------------------------------------------- */

#define SUBSTEP_S 5e-6

enum { ANGLE, TORQUE, CURRENT, ACCELERATION, CHANNELS };
static const char *const channel_names[CHANNELS] = {"encoder", "torque", "current", "accelerometer"};

enum { INTERLOCK = 12, UNPLUGGED = 31, WATCHDOG = 40 };
static const haptic_rig_code codes[] = {
    {INTERLOCK, "the interlock is open; close the door"},
    {UNPLUGGED, "the card no longer answers; check its cable"},
    {WATCHDOG, "the watchdog ran out and took the torque away; start the run again"},
};

typedef struct plant {
    /* What it is made of: mNm, rad, s. */
    double rotor_inertia, knob_inertia, coulomb_mnm, viscous, detent_mnm, detents_per_turn;
    double torque_noise_mnm, acceleration_noise;
    double counts_per_turn, torque_constant_mnm_a, rate_hz, watchdog_s;
    double motor_sign, encoder_sign;
    /* How it dates what it measures: shares of a period, parts per million. */
    double late, jitter, drift_ppm;
    /* Every so many ticks so many ticks in a row bring nothing new. */
    double stale_every, stale_for;
    /* What goes wrong, and when, s after it was switched on. */
    const char *fault;
    double fault_s, stall_s;
    /* System calls that an exchange makes, as a card's driver would make its own. */
    double calls;
    /* Its state. */
    double angle, velocity, acceleration, torque_mnm, motor_mnm;
    double time_s;            /* of the plant, from when it was switched on */
    uint64_t begun_ns, commanded_ns, tick;
    uint64_t random;
    int is_on, has_stalled;
} plant;

static double uniform(plant *p)
{
    p->random = p->random * 6364136223846793005u + 1442695040888963407u;
    return (double)(p->random >> 11) / 9007199254740992.0;
}

static double normal(plant *p)
{
    return sqrt(-2.0 * log(1.0 - uniform(p))) * cos(2.0 * M_PI * uniform(p));
}

/* One substep: kick by the smooth torques, brake by Coulomb friction without ever reversing, drift. */
static void substep(plant *p, double h)
{
    double inertia = p->rotor_inertia + p->knob_inertia;
    double before = p->velocity;
    double smooth = p->motor_mnm - p->viscous * p->velocity - p->detent_mnm * sin(p->detents_per_turn * p->angle);
    double velocity = before + h * smooth / inertia;
    double brake = h * p->coulomb_mnm / inertia;
    velocity = fabs(velocity) <= brake ? 0.0 : velocity - copysign(brake, velocity);
    p->velocity = velocity;
    p->angle += 0.5 * h * (before + velocity);
    p->acceleration = (velocity - before) / h;
    /* The sensor sits between rotor and knob. */
    p->torque_mnm = p->motor_mnm - p->rotor_inertia * p->acceleration;
}

static void turn_to(plant *p, double time_s)
{
    while (p->time_s < time_s) {
        double h = fmin(SUBSTEP_S, time_s - p->time_s);
        if (h < 1e-9)
            h = 1e-9;
        substep(p, h);
        p->time_s += h;
    }
}

static int fails(const plant *p, const char *fault)
{
    return p->fault && strcmp(p->fault, fault) == 0 && p->time_s >= p->fault_s;
}

/* ---- the interface ----------------------------------------------------------------------------------------------- */

uint32_t haptic_rig_abi(void)
{
    return HAPTIC_RIG_ABI;
}

int32_t haptic_rig_open(const haptic_rig_setting *settings, uint32_t count, void **rig)
{
    plant *p = calloc(1, sizeof *p);
    if (!p)
        return 1;
    *p = (plant){.rotor_inertia = 0.02, .knob_inertia = 0.06, .coulomb_mnm = 3.0, .viscous = 0.25, .detent_mnm = 4.0,
                 .detents_per_turn = 24.0, .torque_noise_mnm = 0.25, .acceleration_noise = 1.0, .counts_per_turn = 640000.0,
                 .torque_constant_mnm_a = 16.4, .rate_hz = 10000.0, .watchdog_s = 0.1, .motor_sign = 1.0,
                 .encoder_sign = 1.0, .random = 1};
    struct { const char *key; double *value; } numbers[] = {
        {"rotor_inertia", &p->rotor_inertia}, {"knob_inertia", &p->knob_inertia}, {"coulomb_mnm", &p->coulomb_mnm},
        {"viscous", &p->viscous}, {"detent_mnm", &p->detent_mnm}, {"detents_per_turn", &p->detents_per_turn},
        {"torque_noise_mnm", &p->torque_noise_mnm}, {"acceleration_noise", &p->acceleration_noise}, {"counts_per_turn", &p->counts_per_turn},
        {"torque_constant_mnm_a", &p->torque_constant_mnm_a}, {"rate_hz", &p->rate_hz},
        {"watchdog_s", &p->watchdog_s}, {"motor_sign", &p->motor_sign}, {"encoder_sign", &p->encoder_sign},
        {"late", &p->late}, {"jitter", &p->jitter}, {"drift_ppm", &p->drift_ppm}, {"stale_every", &p->stale_every},
        {"stale_for", &p->stale_for}, {"calls", &p->calls}, {"fault_s", &p->fault_s}, {"stall_s", &p->stall_s},
    };
    for (uint32_t i = 0; i < count; i++) {
        for (size_t k = 0; k < sizeof numbers / sizeof *numbers; k++)
            if (strcmp(settings[i].key, numbers[k].key) == 0)
                *numbers[k].value = atof(settings[i].value);
        if (strcmp(settings[i].key, "fault") == 0)
            p->fault = strdup(settings[i].value);
    }
    *rig = p;
    return 0;
}

void haptic_rig_describe(void *rig, haptic_rig_description *description)
{
    plant *p = rig;
    description->name = "rotary plant";
    description->channels = channel_names;
    description->channel_count = CHANNELS;
    description->codes = codes;
    description->code_count = sizeof codes / sizeof *codes;
    description->watchdog_s = fails(p, "slow-watchdog") ? 5.0 : p->watchdog_s;
}

int32_t haptic_rig_prepare(void *rig, int32_t (*stop)(void *context), void *context)
{
    plant *p = rig;
    /* A drive that takes its time to come up. */
    for (int tenths = 0; fails(p, "slow-start") && tenths < 150; tenths++) {
        if (stop(context))
            return 1;
        usleep(100000);
    }
    return 0;
}

int32_t haptic_rig_enable(void *rig)
{
    plant *p = rig;
    if (fails(p, "refuses"))
        return INTERLOCK;
    p->is_on = 1;
    return 0;
}

void haptic_rig_disable(void *rig)
{
    plant *p = rig;
    p->is_on = 0;
    p->motor_mnm = 0.0;
}

int32_t haptic_rig_exchange(void *rig, uint64_t due_ns, double torque, haptic_rig_measurement *measurement)
{
    plant *p = rig;
    double period_s = 1.0 / p->rate_hz;
    (void)torque; /* haptic_rig_write_torque has it */
    for (int call = 0; call < (int)p->calls; call++)
        syscall(SYS_getpid);
    if (!p->begun_ns)
        p->begun_ns = p->commanded_ns = due_ns;
    /* The sensors are read when the bus gets to them: some part of a period after the tick. */
    double after_s = period_s * (p->late + p->jitter * uniform(p));
    double before_s = p->time_s;
    turn_to(p, 1e-9 * (double)(due_ns - p->begun_ns) + after_s);
    if (1e-9 * (double)(due_ns - p->commanded_ns) > p->watchdog_s) {
        p->is_on = 0;
        p->motor_mnm = 0.0;
        return WATCHDOG;
    }
    if (fails(p, "unplugged"))
        return UNPLUGGED;
    if (fails(p, "blocks"))
        sleep(15);
    if (fails(p, "stalls") && !p->has_stalled++)
        usleep((useconds_t)(1e6 * p->stall_s));
    if (fails(p, "crashes"))
        *(volatile int *)0 = 0;
    /* Its clock was set to CLOCK_MONOTONIC at the first exchange and runs at its own pace since. */
    double time_s = p->time_s * (1.0 + 1e-6 * p->drift_ppm);
    measurement->time_ns = p->begun_ns + (uint64_t)(1e9 * time_s);
    p->tick++;
    int is_stale = p->stale_every > 0.0 && fmod((double)p->tick, p->stale_every) < p->stale_for && p->tick > 100;
    measurement->valid = is_stale || p->time_s == before_s ? 0u : (1u << CHANNELS) - 1u;
    measurement->value[ANGLE] = p->encoder_sign * floor(p->angle * p->counts_per_turn / (2.0 * M_PI));
    measurement->value[TORQUE] = p->torque_mnm + p->torque_noise_mnm * normal(p);
    /* The current is what was commanded over the period that ends here: half a period old at the mean. */
    measurement->value[CURRENT] = (p->motor_mnm + p->torque_noise_mnm * normal(p)) / p->torque_constant_mnm_a;
    measurement->value[ACCELERATION] = p->acceleration + p->acceleration_noise * normal(p);
    if (fails(p, "nan"))
        measurement->value[ANGLE] = NAN;
    return 0;
}

int32_t haptic_rig_write_torque(void *rig, double torque)
{
    plant *p = rig;
    /* A card would time the write itself; the plant's time stands where the sensors were read. */
    p->commanded_ns = p->begun_ns + (uint64_t)(1e9 * p->time_s);
    p->motor_mnm = p->is_on ? p->motor_sign * torque : 0.0;
    return 0;
}

void haptic_rig_close(void *rig)
{
    plant *p = rig;
    free((char *)p->fault);
    free(p);
}

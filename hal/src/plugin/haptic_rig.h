/*
 * haptic_rig.h: what a shared library must offer so that the haptic camera can drive a rig with it.
 *
 * Version 1. A library implements the functions below and is named in a rig file:
 *
 *     driver = "plugin"
 *     [settings]
 *     library = "my_rig.so"
 *     anything = "else"          # handed to haptic_rig_open as text
 *
 * Build:  cc -O2 -shared -fPIC -o my_rig.so my_rig.c
 * Try:    haptic-camera rig check my_rig.toml
 *
 * Order of calls: haptic_rig_abi, haptic_rig_open, haptic_rig_describe; then, in a run, haptic_rig_prepare, haptic_rig_describe
 * once more, haptic_rig_enable, haptic_rig_exchange and haptic_rig_write_torque once per tick, haptic_rig_disable; at last
 * haptic_rig_close. Calls never overlap. haptic_rig_enable, _exchange, _write_torque and _disable come from one real-time thread:
 * between haptic_rig_enable and haptic_rig_disable nothing may allocate, lock, log or block. System calls that do not block
 * are permitted if the rig file declares them ([calls] names and per_tick).
 *
 * A function that returns int32_t returns 0 for success, or a code of the device's own. The code is published, recorded
 * with the capture and reported to the operator with the meaning that haptic_rig_describe gives it.
 *
 * If the program dies, the amplifier must take the torque away by itself: arm its watchdog in haptic_rig_prepare.
 */
#ifndef HAPTIC_RIG_H
#define HAPTIC_RIG_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The version of this interface: what haptic_rig_abi returns. */
#define HAPTIC_RIG_ABI 1u

/* Most channels of a device. */
#define HAPTIC_RIG_CHANNELS 16

/* An entry of the rig file's [settings], both as text: `gain = 0.5` comes as "gain" and "0.5". The sample rate comes as
 * "rate_hz", the watchdog's time that the rig file asks for as "watchdog_s". */
typedef struct haptic_rig_setting {
    const char *key;
    const char *value;
} haptic_rig_setting;

/* A code of the device and what it means, as a half sentence that says what to do. */
typedef struct haptic_rig_code {
    int32_t code;
    const char *meaning;
} haptic_rig_code;

/* What the device is. Pointers stay valid until haptic_rig_close. */
typedef struct haptic_rig_description {
    const char *name;                /* of the device, for the archive; may be NULL */
    uint32_t channel_count;          /* up to HAPTIC_RIG_CHANNELS */
    uint32_t code_count;
    const char *const *channels;     /* names of the channels, which the rig file's [channels] refer to */
    const haptic_rig_code *codes;    /* may be NULL if code_count is 0 */
    double watchdog_s;               /* time of the amplifier's watchdog as read back from it, s; 0 while it is not known */
} haptic_rig_description;

/* What was measured at a tick. It is all zero when haptic_rig_exchange is called. */
typedef struct haptic_rig_measurement {
    uint64_t time_ns;                /* when the encoder was read, ns of CLOCK_MONOTONIC, or of a clock of the device's own
                                        that was set to it in haptic_rig_enable; 0 for the time at which the tick was due */
    int64_t shift_ns;                /* by how much later the ticks from the next one on should come; 0 to keep the schedule */
    uint32_t valid;                  /* bit i: value[i] is new; a tick whose angle or torque is not new counts as stale */
    uint32_t reserved;
    double value[HAPTIC_RIG_CHANNELS]; /* in the device's own units: the rig file scales them; of a digital input 0 or 1 */
} haptic_rig_measurement;

/* HAPTIC_RIG_ABI of the header that the library was built with. */
uint32_t haptic_rig_abi(void);

/* Makes a rig from the settings. It may allocate, but must not move anything. */
int32_t haptic_rig_open(const haptic_rig_setting *settings, uint32_t count, void **rig);

/* Fills in what the device is. Called after haptic_rig_open and again after haptic_rig_prepare. */
void haptic_rig_describe(void *rig, haptic_rig_description *description);

/* Brings the device up, on an ordinary thread: it may take its time if it asks stop(context) several times a second and returns
 * soon (anything but 0) once that is not 0. */
int32_t haptic_rig_prepare(void *rig, int32_t (*stop)(void *context), void *context);

/* Switches the amplifier on at zero torque. Short: a millisecond, not a second. */
int32_t haptic_rig_enable(void *rig);

/* Switches the amplifier off. Called once, also after a failure; harmless if it is off. */
void haptic_rig_disable(void *rig);

/* Takes the sensors at the tick that is due at due_ns (CLOCK_MONOTONIC). `torque` is what the motor is to make from now on, in the
 * units of the rig file's [channels.motor]; a library with haptic_rig_write_torque ignores it. */
int32_t haptic_rig_exchange(void *rig, uint64_t due_ns, double torque, haptic_rig_measurement *measurement);

/* OPTIONAL. Sets the motor's torque at once: for a card that can write between two readings, and is a period faster by it. A code ends
 * the run, even if the sensors can be read. */
int32_t haptic_rig_write_torque(void *rig, double torque);

/* Frees the rig. */
void haptic_rig_close(void *rig);

#ifdef __cplusplus
}
#endif

#endif

/*
 * A rotor with a knob behind the outputs of the kernel's comedi_test, whose inputs read what its outputs were last set to: it reads the
 * motor's voltage from channel 0 and sets the voltages of angle and torque sensor on channels 1 and 2. It goes by the clock.
 */
#include <comedilib.h>
#include <math.h>
#include <stdio.h>
#include <time.h>

#define PERIOD_NS 100000
#define SUBSTEPS 10
/* mNm, rad, s. */
static const double rotor = 0.02, knob = 0.06, coulomb = 3.0, viscous = 0.25, detent = 4.0, detents_per_turn = 24.0;
static const double mnm_per_volt = 10.0, volts_per_rad = 10.0 / M_PI;

int main(void)
{
    comedi_t *card = comedi_open("/dev/comedi0");
    if (!card)
        return 1;
    int out = comedi_find_subdevice_by_type(card, COMEDI_SUBD_AO, 0), in = comedi_find_subdevice_by_type(card, COMEDI_SUBD_AI, 0);
    comedi_range *range = comedi_get_range(card, (unsigned)in, 0, 0);
    lsampl_t most = comedi_get_maxdata(card, (unsigned)in, 0), motor, angle_told, torque_told;
    comedi_insn instructions[] = {
        {.insn = INSN_WRITE, .n = 1, .data = &angle_told, .subdev = (unsigned)out, .chanspec = CR_PACK(1, 0, AREF_GROUND)},
        {.insn = INSN_WRITE, .n = 1, .data = &torque_told, .subdev = (unsigned)out, .chanspec = CR_PACK(2, 0, AREF_GROUND)},
        {.insn = INSN_READ, .n = 1, .data = &motor, .subdev = (unsigned)in, .chanspec = CR_PACK(0, 0, AREF_GROUND)},
    };
    comedi_insnlist list = {.n_insns = 3, .insns = instructions};
    double motor_mnm = 0.0, angle = 0.0, velocity = 0.0, torque_mnm = 0.0;
    /* Outputs hold nothing of their own before they are first set: the motor's is to be zero. */
    comedi_data_write(card, (unsigned)out, 0, 0, AREF_GROUND, comedi_from_phys(0.0, range, most));
    struct timespec due;
    clock_gettime(CLOCK_MONOTONIC, &due);
    for (int begun = 0;; begun = 1) {
        for (int i = 0; begun && i < SUBSTEPS; i++) {
            double h = 1e-9 * PERIOD_NS / SUBSTEPS, before = velocity;
            double smooth = motor_mnm - viscous * before - detent * sin(detents_per_turn * angle);
            double kicked = before + h * smooth / (rotor + knob), brake = h * coulomb / (rotor + knob);
            velocity = fabs(kicked) <= brake ? 0.0 : kicked - copysign(brake, kicked);
            angle += 0.5 * h * (before + velocity);
            torque_mnm = motor_mnm - rotor * (velocity - before) / h;
        }
        angle_told = comedi_from_phys(angle * volts_per_rad, range, most);
        torque_told = comedi_from_phys(torque_mnm / mnm_per_volt, range, most);
        if (comedi_do_insnlist(card, &list) != 3)
            return 2;
        motor_mnm = mnm_per_volt * comedi_to_phys(motor, range, most);
        if (!begun)
            puts("ready"), fflush(stdout);
        due.tv_nsec += PERIOD_NS;
        if (due.tv_nsec >= 1000000000)
            due.tv_sec++, due.tv_nsec -= 1000000000;
        clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &due, NULL);
    }
}

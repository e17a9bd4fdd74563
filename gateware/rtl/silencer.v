// Moves phase and amplitude of a channel towards their targets by a limited step per period, the phase along the
// shorter way. The result comes two clocks later.
`default_nettype none

module silencer (
    input  wire        clk,
    input  wire [15:0] phase_step,
    input  wire [15:0] amplitude_step,
    input  wire [7:0]  phase_target,
    input  wire [7:0]  amplitude_target,
    input  wire [15:0] phase,           // in 1/256 of a unit
    input  wire [15:0] amplitude,
    output reg  [15:0] phase_next,
    output reg  [15:0] amplitude_next
);
    wire [15:0] turn = {phase_target, 8'd0} - phase;
    wire [15:0] aim = {amplitude_target, 8'd0};
    wire        lower = aim < amplitude;

    reg [15:0] phase_held, phase_aim, phase_far;
    reg        phase_down;
    reg [15:0] amplitude_held, amplitude_aim, amplitude_far;
    reg        amplitude_down;

    always @(posedge clk) begin
        phase_held <= phase;
        phase_aim <= {phase_target, 8'd0};
        phase_far <= turn[15] ? -turn : turn;
        phase_down <= turn[15];

        amplitude_held <= amplitude;
        amplitude_aim <= aim;
        amplitude_far <= lower ? amplitude - aim : aim - amplitude;
        amplitude_down <= lower;

        phase_next <= phase_far <= phase_step ? phase_aim
            : phase_down ? phase_held - phase_step : phase_held + phase_step;
        amplitude_next <= amplitude_far <= amplitude_step ? amplitude_aim
            : amplitude_down ? amplitude_held - amplitude_step : amplitude_held + amplitude_step;
    end
endmodule

`default_nettype wire

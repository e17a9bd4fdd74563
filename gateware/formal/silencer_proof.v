// silencer, for any numbers: without a target the amplitude falls by a full step or to zero, so that a mute of 0x0100
// per period ends after 255 periods; and no value changes by more than a step.
`default_nettype none
module silencer_proof (
    input wire        clk,
    input wire [15:0] phase_step,
    input wire [15:0] amplitude_step,
    input wire [7:0]  phase_target,
    input wire [7:0]  amplitude_target,
    input wire [15:0] phase,
    input wire [15:0] amplitude
);
    wire [15:0] phase_next, amplitude_next;
    silencer silencer (
        .clk(clk), .phase_step(phase_step), .amplitude_step(amplitude_step),
        .phase_target(phase_target), .amplitude_target(amplitude_target),
        .phase(phase), .amplitude(amplitude), .phase_next(phase_next), .amplitude_next(amplitude_next)
    );

    // The input two clocks ago; the steps are evaluated a clock later than the rest.
    reg [1:0]  age = 2'd0;
    reg [15:0] phase_1, phase_2, amplitude_1, amplitude_2, phase_step_1, amplitude_step_1;
    reg [7:0]  phase_target_1, phase_target_2, amplitude_target_1, amplitude_target_2;
    always @(posedge clk) begin
        if (age != 2'd2) age <= age + 2'd1;
        {phase_1, amplitude_1, phase_target_1, amplitude_target_1} <= {phase, amplitude, phase_target, amplitude_target};
        {phase_2, amplitude_2, phase_target_2, amplitude_target_2} <= {phase_1, amplitude_1, phase_target_1, amplitude_target_1};
        {phase_step_1, amplitude_step_1} <= {phase_step, amplitude_step};
    end
    wire [15:0] gone = amplitude_next > amplitude_2 ? amplitude_next - amplitude_2 : amplitude_2 - amplitude_next;
    wire [15:0] turned = phase_next - phase_2;
    wire [15:0] turned_by = turned[15] ? -turned : turned;
    wire [15:0] before = {phase_target_2, 8'd0} - phase_2;
    wire [15:0] after = {phase_target_2, 8'd0} - phase_next;
    always @(posedge clk) if (age == 2'd2) begin
        assert (gone <= amplitude_step_1 && turned_by <= phase_step_1);
        if (amplitude_target_2 == 8'd0) assert (amplitude_next == (amplitude_2 > amplitude_step_1 ? amplitude_2 - amplitude_step_1 : 16'd0));
        // Never farther away than before.
        assert ((after[15] ? -after : after) <= (before[15] ? -before : before));
        cover (amplitude_target_2 == 8'd0 && amplitude_next == 16'd0 && amplitude_2 == amplitude_step_1);
        cover (before == 16'h8000 && turned[15]);
    end
endmodule

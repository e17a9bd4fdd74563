// The emergency stop. A press of any length is caught asynchronously and held until released; `stopped` and `pressed`
// are its synchronised versions, two clocks later.
`default_nettype none

module emergency (
    input  wire clk,
    input  wire reset,
    input  wire estop_n,    // low: pressed
    input  wire let_go,     // for one clock
    output reg  caught,     // or `estop_n` low: the outputs have to be off
    output wire stopped,
    output wire pressed
);
    wire released;
    synchroniser synchronise_stopped (.clk(clk), .reset(1'b0), .from_outside(caught), .synchronised(stopped));
    // Pressed until known otherwise.
    synchroniser #(.AFTER_RESET(1'b0)) synchronise_pressed (
        .clk(clk), .reset(reset), .from_outside(estop_n), .synchronised(released)
    );
    assign pressed = !released;

    always @(posedge clk or negedge estop_n) begin
        if (!estop_n) caught <= 1'b1;
        else if (reset || let_go) caught <= 1'b0;
    end
endmodule

`default_nettype wire

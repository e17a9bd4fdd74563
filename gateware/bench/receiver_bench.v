// receiver: good packets wait with all they carry, up to four; whatever is not quite right is spoiled. The fuzz test goes further.
`include "check.vh"
module receiver_bench;
    `include "bench.vh"
    reg         reset = 1, valid = 0, framing = 0, done = 0;
    reg  [7:0]  data = 0;
    wire        ready, good, spoiled, by_line;
    wire [7:0]  packet_type, packet_seq, read_data;
    wire [31:0] arguments;
    wire [9:0]  length;
    reg  [8:0]  address = 0;
    receiver receiver (
        .clk(clk), .reset(reset), .valid(valid), .data(data), .framing(framing),
        .ready(ready), .packet_type(packet_type), .packet_seq(packet_seq), .arguments(arguments), .length(length),
        .read_address(address), .read_data(read_data), .done(done),
        .good(good), .spoiled(spoiled), .spoiled_by_line(by_line)
    );
    integer goods = 0, spoils = 0, lines = 0;
    always @(posedge clk) begin
        if (good) goods = goods + 1;
        if (spoiled) spoils = spoils + 1;
        if (spoiled && by_line) lines = lines + 1;
    end

    // A packet of so many bytes before its CRC, made from a seed; an odd seed gives it many zeros.
    reg [7:0] body [0:1023];
    integer   i, j, at, from;
    reg [15:0] crc;
    task make(input integer bytes, input [7:0] seed);
        begin
            crc = 16'hFFFF;
            for (i = 0; i < bytes; i = i + 1) begin
                body[i] = seed[0] && i % 5 == 1 ? 8'd0 : seed[0] ? i * 7 + seed : (i * 7 + seed) | 8'd1;
                crc = crc ^ {body[i], 8'h00};
                for (j = 0; j < 8; j = j + 1) crc = crc[15] ? (crc << 1) ^ 16'h1021 : crc << 1;
            end
            {body[bytes], body[bytes+1]} = ~crc;
        end
    endtask
    task put(input [7:0] value);
        begin
            {valid, data} = {1'b1, value};
            @(negedge clk) valid = 0;
            @(negedge clk);
        end
    endtask
    task send(input integer bytes);
        begin
            from = 0;
            while (from <= bytes) begin
                at = from;
                while (at < bytes && body[at] != 0 && at - from < 254) at = at + 1;
                put(at - from + 1);
                for (i = from; i < at; i = i + 1) put(body[i]);
                from = at == bytes ? bytes + 1 : at - from == 254 ? at : at + 1;
            end
            put(0);
        end
    endtask
    task counts(input integer g, input integer s, input integer l);
        begin
            repeat (3) @(negedge clk);
            `CHECK("good packets", goods, g)
            `CHECK("spoiled packets", spoils, s)
            `CHECK("packets spoiled by the line", lines, l)
        end
    endtask
    // The packet in front is the one of this seed.
    task take(input integer bytes, input [7:0] seed);
        begin
            make(bytes, seed);
            `CHECK("ready", ready, 1'b1)
            `CHECK("the header", {arguments, packet_seq, packet_type}, {body[5], body[4], body[3], body[2], body[1], body[0]})
            `CHECK("the length", length, bytes - 6)
            for (i = 6; i < bytes; i = i + 1) begin
                address = i - 6;
                @(negedge clk) `CHECK("a byte", read_data, body[i])
            end
            done = 1;
            @(negedge clk) done = 0;
        end
    endtask

    initial begin
        repeat (2) @(negedge clk);
        reset = 0;
        repeat (4) put(0);
        counts(0, 0, 0);
        make(518, 1); send(520);
        make(6, 2); send(8);
        make(262, 3); send(264);
        make(7, 4); send(9);
        counts(4, 0, 0);
        // No room for a fifth, and none of the four is touched by it.
        make(262, 5); send(264);
        counts(4, 1, 0);
        take(518, 1);
        make(518, 6); send(520);
        take(6, 2);
        take(262, 3);
        take(7, 4);
        take(518, 6);
        counts(5, 1, 0);
        `CHECK("ready with nothing", ready, 1'b0)

        make(519, 7); send(521);                        // too long
        make(5, 8); send(7);                            // too short
        make(100, 9); body[50] = body[50] ^ 1; send(102);
        put(9); put(1); put(0);                         // ends within a block
        counts(5, 5, 0);
        framing = 1; @(negedge clk) framing = 0;        // a good one after something that was no byte
        make(6, 10); send(8);
        counts(5, 6, 1);
        make(6, 11); send(8);
        counts(6, 6, 1);
        take(6, 11);
        `END
    end
endmodule

// Counts what YAMCS sends as Polhode wants it (config/bus/commands.toml): 1 .. 16383, as 0 stands for none. The count begins at the
// time of the server's start, so that the commands of a server that was started anew are not taken for those of the one before.
import java.nio.ByteBuffer;
import java.time.Instant;
import java.util.concurrent.atomic.AtomicInteger;
import org.yamcs.commanding.PreparedCommand;
import org.yamcs.pus.PusCommandPostprocessor;

public class CountingCommandPostprocessor extends PusCommandPostprocessor {
    private static final int APID_BITS = 0x7FF;
    private static final int COUNTS = 0x3FFF;
    private static final AtomicInteger LAST = new AtomicInteger((int) (Instant.now().getEpochSecond() % COUNTS)); // of all links

    @Override
    public byte[] process(PreparedCommand command) {
        int apid = ByteBuffer.wrap(command.getBinary()).getShort() & APID_BITS;
        seqFiller.setSequence(apid, LAST.updateAndGet(last -> last % COUNTS + 1));
        return super.process(command);
    }
}

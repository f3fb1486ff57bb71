// Signs what YAMCS sends: the trailer of docs/security.md behind what CountingCommandPostprocessor makes.
import java.io.IOException;
import java.nio.ByteBuffer;
import java.nio.file.Files;
import java.nio.file.Path;
import java.nio.file.attribute.PosixFilePermissions;
import java.security.GeneralSecurityException;
import java.time.Instant;
import java.util.Arrays;
import java.util.HexFormat;
import java.util.concurrent.atomic.AtomicLong;
import javax.crypto.Mac;
import javax.crypto.spec.SecretKeySpec;
import org.yamcs.ConfigurationException;
import org.yamcs.YConfiguration;
import org.yamcs.commanding.PreparedCommand;
import org.yamcs.tctm.Link;

public class SigningCommandPostprocessor extends CountingCommandPostprocessor {
    private static final int HEADER_OCTETS = 6;
    private static final int LENGTH_OCTET = 4;
    private static final int KEY_OCTETS = 32;
    private static final int MAC_OCTETS = 16;
    private static final int TRAILER_OCTETS = Long.BYTES + MAC_OCTETS;
    private static final AtomicLong LAST = new AtomicLong(); // of all links: they may share a key

    private SecretKeySpec key;

    @Override
    public void init(String instance, YConfiguration config, Link link) {
        super.init(instance, config, link);
        Path file = Path.of(config.getString("key"));
        try {
            String mode = PosixFilePermissions.toString(Files.getPosixFilePermissions(file));
            byte[] octets = HexFormat.of().parseHex(Files.readString(file).strip());
            if (!mode.endsWith("------") || octets.length != KEY_OCTETS) {
                throw new ConfigurationException(file + ": a key is 64 hexadecimal digits in a file of mode 0600 or 0400");
            }
            key = new SecretKeySpec(octets, "HmacSHA256");
        } catch (IOException | IllegalArgumentException problem) {
            throw new ConfigurationException(file + ": cannot be read as a key: " + problem.getMessage());
        }
    }

    @Override
    public byte[] process(PreparedCommand command) {
        byte[] packet = super.process(command);
        return packet == null ? null : sign(packet);
    }

    @Override
    public int getBinaryLength(PreparedCommand command) {
        return super.getBinaryLength(command) + TRAILER_OCTETS;
    }

    private byte[] sign(byte[] packet) {
        Instant now = Instant.now();
        long now_ns = now.getEpochSecond() * 1_000_000_000L + now.getNano();
        ByteBuffer out = ByteBuffer.wrap(Arrays.copyOf(packet, packet.length + TRAILER_OCTETS));
        out.putShort(LENGTH_OCTET, (short) (out.capacity() - HEADER_OCTETS - 1));
        out.putLong(packet.length, LAST.updateAndGet(last -> Math.max(now_ns, last + 1)));
        try {
            Mac mac = Mac.getInstance("HmacSHA256");
            mac.init(key);
            mac.update(out.array(), 0, out.capacity() - MAC_OCTETS);
            out.put(out.capacity() - MAC_OCTETS, mac.doFinal(), 0, MAC_OCTETS);
        } catch (GeneralSecurityException problem) {
            throw new IllegalStateException(problem);
        }
        return out.array();
    }
}
